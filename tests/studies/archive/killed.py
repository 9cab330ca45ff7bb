"""A worker killed while it computes: what that costs, and that no result is lost or another."""

import os
import signal
import time
from collections.abc import Sequence
from dataclasses import dataclass

from tests.studies.archive.compared import Tell, bits_of, parts_of
from truepose.analysis.archive import ArchivedCampaign
from truepose.analysis.archive_outcomes import analyse
from truepose.analysis.parallel.dask_pool import DaskPlaces, of_this_computer
from truepose.analysis.parallel.tasks import Cluster, PartAnswer


@dataclass(frozen=True, slots=True)
class Killed:
    """A run in which workers were killed."""

    campaigns: int
    kills: int
    lost: int  # results that never came
    other_bits: int
    wall_s: float

    @property
    def reached(self) -> bool:
        """Whether every result came, with the same bits."""
        return self.kills > 0 and self.lost == 0 and self.other_bits == 0

    def told(self) -> str:
        """In words."""
        return (
            f"{self.kills} of two workers killed within {self.campaigns} campaigns: {self.lost} results "
            f"lost, {self.other_bits} with other bits, {self.wall_s:.1f} s\n"
        )


def killed_in_the_middle(campaigns: Sequence[ArchivedCampaign], bits: dict[str, str], tell: Tell) -> Killed:
    """Kill a worker once a third of the results are there, and count what comes nevertheless."""
    found: dict[str, str] = {}
    kills = 0
    began_s = time.perf_counter()
    with of_this_computer(2) as places:
        for outcome in Cluster(places).outcomes(analyse, parts_of(campaigns)):
            if isinstance(outcome, PartAnswer):
                found[outcome.name] = bits_of(outcome.answer)
            if not kills and 3 * len(found) >= len(campaigns):
                tell(f"killing process {_kill_one(places)}")
                kills += 1
    lost = len(campaigns) - len(found)
    other = sum(bits[name] != one for name, one in found.items())
    return Killed(len(campaigns), kills, lost, other, time.perf_counter() - began_s)


def _kill_one(places: DaskPlaces) -> int:
    process: int = min(places.client.run(os.getpid).values())
    os.kill(process, signal.SIGKILL)
    return process
