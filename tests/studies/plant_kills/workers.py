"""Two workers of Dask that compute parts of an archive while one of them is killed."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import numpy as np

from tests.studies.archive.compared import bits_of, parts_of
from tests.studies.archive.recorded import recorded_archive
from truepose.analysis.archive import ArchivedCampaign
from truepose.analysis.archive_outcomes import analyse
from truepose.analysis.errors import ClusterError
from truepose.analysis.parallel.dask_pool import DaskPlaces, of_this_computer
from truepose.analysis.parallel.tasks import Cluster, PartAnswer

_CAMPAIGNS: Final = 3
_READINGS: Final = 40
_PATIENCE_S: Final = 120.0


class Workers:
    """Computes the same parts again and again, and compares the bits with those before anybody was killed."""

    def __init__(self, places: DaskPlaces, campaigns: list[ArchivedCampaign]) -> None:
        self._places, self._campaigns = places, campaigns
        self._bits: dict[str, str] = {}
        self._usual_s = 1.0  # that a round takes
        self.lost = self.other_bits = self.computed = 0
        self._compute()

    def round(self, rng: np.random.Generator) -> bool:
        """Compute all parts while a worker is killed; returns whether they were still being computed then.

        It may be one that starts: it is started again as well.
        """
        computing = threading.Event()
        computing.set()
        seen: list[bool] = []

        def kill() -> None:
            _kill_one(self._places, rng)
            seen.append(computing.is_set())

        killing = threading.Timer(float(rng.uniform(0.0, self._usual_s)), kill)
        began_s = time.monotonic()
        killing.start()
        self._compute()
        computing.clear()
        self._usual_s = time.monotonic() - began_s
        killing.join()
        return seen[0]

    def _compute(self) -> None:
        came = 0
        for outcome in Cluster(self._places).outcomes(analyse, parts_of(self._campaigns)):
            if isinstance(outcome, PartAnswer):
                came += 1
                bits = bits_of(outcome.answer)
                self.other_bits += bits != self._bits.setdefault(outcome.name, bits)
        self.computed += came
        self.lost += len(self._campaigns) - came


def _kill_one(places: DaskPlaces, rng: np.random.Generator) -> None:
    """Kill a worker that lives; there is one again soon."""
    until_s = time.monotonic() + _PATIENCE_S
    while time.monotonic() < until_s:
        alive = [nanny.pid for nanny in places.client.cluster.workers.values() if nanny.pid]
        if alive:
            os.kill(int(rng.choice(alive)), signal.SIGKILL)
            return
        time.sleep(0.05)
    raise ClusterError("No worker came back.")


@contextmanager
def two_workers(folder: Path) -> Iterator[Workers]:
    """Offer two workers of this computer and what they compute."""
    campaigns = recorded_archive(folder, _CAMPAIGNS, _READINGS, ["irb120-clean"])
    with of_this_computer(2) as places:
        yield Workers(places, campaigns)
