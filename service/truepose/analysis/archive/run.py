"""An archive computed anew: each campaign once for its data and this version, whatever interrupts it."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.analysis.archive.campaigns import Archived, sha256
from truepose.analysis.archive.changes import Change, change
from truepose.analysis.archive.outcome import Found, Key, Results, ToAnalyse, analyse
from truepose.analysis.cluster.alike import program
from truepose.analysis.cluster.cluster import Cluster
from truepose.analysis.cluster.parts import Failed, Part
from truepose.domain.errors import ConfigurationError, TrueposeError

Told = Callable[[float, str], None]
_RESULTS: Final = "results"


@dataclass(frozen=True, slots=True)
class Anew:
    """What came of an archive."""

    changes: tuple[Change, ...]  # in the order of the archive
    computed: int
    there_already: int

    @property
    def failed(self) -> tuple[Change, ...]:
        """Campaigns without a result, each with its reason."""
        return tuple(row for row in self.changes if row.failed)


class Archive:
    """Campaigns, and the folder in which their results are kept."""

    def __init__(
        self,
        campaigns: Sequence[Archived],
        out: Path,
        effects: tuple[str, ...] | None = None,
        against: Path | None = None,
    ) -> None:
        self._campaigns = campaigns
        self._effects = effects
        self._results = Results(_folder(out))
        self._earlier = self._results if against is None else Results(_results_of(against))
        self._keys: dict[int, Key] = {}  # by the place of the campaign in the archive
        self._failed: dict[int, str] = {}
        self._asked: list[int] = []  # places of the parts that were sent

    def compute(self, cluster: Cluster, told: Told) -> Anew:
        """Compute what is not there yet, and compare all of it with what was found before.

        A result is on disk before the next one is waited for. Raises ClusterError where workers are lost for
        good: what is on disk stays, and the next run goes on from there.
        """
        computed = 0
        for outcome in cluster.outcomes(analyse, self._missing()):
            place = self._asked[outcome.number]
            if isinstance(outcome, Failed):
                self._failed[place] = outcome.why
            else:
                self._results.keep(self._keys[place], outcome.answer)
                computed += 1
            told(len(self._keys) / len(self._campaigns), outcome.name)
        there = len(self._keys) - computed - len(self._failed)
        return Anew(tuple(self._changes()), computed, there)

    def _missing(self) -> Iterator[Part[ToAnalyse]]:
        for place, campaign in enumerate(self._campaigns):
            try:
                content = campaign.load()
            except TrueposeError as error:
                self._failed[place] = str(error)
                content = b""
            key = Key(campaign.name, sha256(content), program(), self._effects)
            self._keys[place] = key
            if place not in self._failed and not self._results.has(key):
                self._asked.append(place)
                yield Part(campaign.name, ToAnalyse(key, content))

    def _changes(self) -> Iterator[Change]:
        for place, campaign in enumerate(self._campaigns):
            key = self._keys[place]
            now = self._results.get(key)
            if now is None:
                yield Change(campaign.name, failed=self._failed[place])
            else:
                yield change(campaign.name, self._before(key, campaign), now)

    def _before(self, key: Key, campaign: Archived) -> Found | None:
        return self._earlier.of_another_program(key) or campaign.before()


def _folder(out: Path) -> Path:
    folder = out / _RESULTS
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _results_of(out: Path) -> Path:
    folder = out / _RESULTS
    if not folder.is_dir():
        raise ConfigurationError(
            f"{out} holds no results of an earlier run; give the folder that --out named."
        )
    return folder
