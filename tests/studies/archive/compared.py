"""The same campaigns on one worker and on two, in turn, and what comes of both."""

import json
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from truepose.analysis.archive import ArchivedCampaign, sha256
from truepose.analysis.archive_outcomes import Key, ToAnalyse, analyse
from truepose.analysis.parallel.arithmetic import program
from truepose.analysis.parallel.tasks import Cluster, Part, PartAnswer, TaskExecutor

_RATIO: Final = 1.8
_OVERHEAD_MS: Final = 10.0
_ALONE: Final = 20  # campaigns that are sent one at a time
Tell = Callable[[str], None]


@dataclass(slots=True)
class Side:
    """What so many workers took for the campaigns so far."""

    workers: int
    wall_s: float = 0.0
    here_s: float = 0.0  # processor time of this process: reading, sending, Dask's scheduler, collecting
    compute_s: float = 0.0  # of all campaigns, where they were computed
    bits: dict[str, str] = field(default_factory=dict)  # of each result, by campaign

    def overhead_ms(self) -> float:
        """Return what a campaign costs beside its computing, the workers' waiting included."""
        return 1e3 * (self.workers * self.wall_s - self.compute_s) / max(len(self.bits), 1)


@dataclass(frozen=True, slots=True)
class Compared:
    """Both sides of the comparison."""

    one: Side
    two: Side
    alone_ms: list[float]  # from sending one campaign to its result, less its computing

    @property
    def ratio(self) -> float:
        """Time of one worker over that of two."""
        return self.one.wall_s / self.two.wall_s

    @property
    def here_ms(self) -> float:
        """Processor time of this process for a campaign, of both sides."""
        return 1e3 * (self.one.here_s + self.two.here_s) / max(2 * len(self.one.bits), 1)

    @property
    def reached(self) -> bool:
        """Whether all figures are as they should be."""
        cheap = max(self.one.overhead_ms(), statistics.median(self.alone_ms)) <= _OVERHEAD_MS
        return self.ratio >= _RATIO and cheap and self.one.bits == self.two.bits

    @property
    def figures(self) -> dict[str, Any]:
        """As a document."""
        return {
            "campaigns": len(self.one.bits),
            "one_s": self.one.wall_s,
            "two_s": self.two.wall_s,
            "ratio": self.ratio,
            "compute_s": self.one.compute_s,
            "overhead_one_ms": self.one.overhead_ms(),
            "overhead_two_ms": self.two.overhead_ms(),
            "here_ms": self.here_ms,
            "alone_ms": self.alone_ms,
            "same_bits": self.one.bits == self.two.bits,
        }

    def told(self) -> str:
        """In words."""
        n = len(self.one.bits)
        same = sum(self.two.bits.get(name) == bits for name, bits in self.one.bits.items())
        return (
            f"{n} campaigns: one worker {self.one.wall_s:.1f} s, two {self.two.wall_s:.1f} s, ratio "
            f"{self.ratio:.2f} (to reach {_RATIO}); same bits {same} of {n}\n"
            f"beside computing: {self.one.overhead_ms():.2f} ms a campaign in a row; sent alone median "
            f"{statistics.median(self.alone_ms):.2f} ms, worst {max(self.alone_ms):.2f} ms of "
            f"{len(self.alone_ms)} (to reach {_OVERHEAD_MS:.0f} ms); processor time of whoever asks, "
            f"scheduler included, {self.here_ms:.2f} ms\n"
        )


def compared(
    campaigns: Sequence[ArchivedCampaign], one: TaskExecutor, two: TaskExecutor, part: int, tell: Tell
) -> Compared:
    """Compute every campaign on both sides, `part` at a time, first on the one and then on the other."""
    sides = Side(1), Side(2)
    clusters = Cluster(one), Cluster(two)
    for cluster in clusters:  # each worker has loaded its modules before anything is timed
        list(cluster.outcomes(analyse, parts_of(campaigns[:4])))
    for turn, first in enumerate(range(0, len(campaigns), part)):
        some = campaigns[first : first + part]
        for which in (0, 1) if turn % 2 == 0 else (1, 0):
            _run(clusters[which], some, sides[which])
        tell(f"{len(sides[0].bits)} of {len(campaigns)}: {sides[0].wall_s:.1f} s, {sides[1].wall_s:.1f} s")
    return Compared(*sides, list(_alone_ms(clusters[0], campaigns[:_ALONE])))


def parts_of(campaigns: Sequence[ArchivedCampaign]) -> Iterator[Part[ToAnalyse]]:
    """Yield what is sent of each campaign."""
    for campaign in campaigns:
        content = campaign.load()
        key = Key(campaign.name, sha256(content), program(), None)
        yield Part(campaign.name, ToAnalyse(key, content))


def _run(cluster: Cluster, campaigns: Sequence[ArchivedCampaign], side: Side) -> None:
    began_s, here_s = time.perf_counter(), time.process_time()
    for outcome in cluster.outcomes(analyse, parts_of(campaigns)):
        if not isinstance(outcome, PartAnswer):
            raise SystemExit(f"{outcome.name}: {outcome.why}")
        side.compute_s += outcome.compute_s
        side.bits[outcome.name] = bits_of(outcome.answer)
    side.wall_s += time.perf_counter() - began_s
    side.here_s += time.process_time() - here_s


def _alone_ms(cluster: Cluster, campaigns: Sequence[ArchivedCampaign]) -> Iterator[float]:
    for part in parts_of(campaigns):
        began_s = time.perf_counter()
        (outcome,) = cluster.outcomes(analyse, [part])
        if isinstance(outcome, PartAnswer):
            yield 1e3 * (time.perf_counter() - began_s - outcome.compute_s)


def bits_of(answer: str) -> str:
    """Return the hash of a result's bits in memory."""
    return str(json.loads(answer)["bits_sha256"])
