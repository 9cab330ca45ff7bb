"""The robots of one type compared from their campaigns, and what the comparison predicts of each."""

import hashlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from truepose.analysis.archive import ArchivedCampaign, sha256
from truepose.analysis.archive_outcomes import keep_whole
from truepose.analysis.fleets.campaigns import (
    CampaignEstimate,
    Entry,
    summary_from,
    tell,
    unfit_of,
    unlike_sentence,
)
from truepose.analysis.parallel.arithmetic import program
from truepose.analysis.parallel.tasks import Cluster, Part, PartFailure
from truepose.domain.errors import ConfigurationError, TrueposeError
from truepose.domain.robot import Robot
from truepose.exchange.tables.files import NOT_STATED, Stated
from truepose.fleet.campaigns import FleetCampaign, fleet_of
from truepose.fleet.changes import Account, account_of
from truepose.fleet.sentences import day_of
from truepose.fleet.trend import LimitCrossing, Priority, due
from truepose.messages.message import Text
from truepose.storage.caches import FleetComparison, LimitForecast
from truepose.storage.errors import DamagedDatabaseError

_MONTH_DAYS: Final = 365.25 / 12.0


def foretold(account: Account, robot: str, newest: int, limit_mm: float, computed_at: str) -> FleetComparison:
    """Return the robots whose change has passed a limit or will, the first to do so first.

    Parameters
    ----------
    account : Account
        Whose days are those of the calendar.
    robot : str
        The type.
    newest : int
        Number of the campaign that was collected last of those compared.
    limit_mm : float
    computed_at : str
    """
    return FleetComparison(robot, computed_at, newest, limit_mm, tuple(_foreseen(due(account, limit_mm))))


def _foreseen(robots: tuple[Priority, ...]) -> Iterator[LimitForecast]:
    for one in robots:
        if one.why == "passes" and one.named is not None:
            change, passes = one.named.change, one.passing
            yield LimitForecast(
                robot=one.robot,
                effect=change.cause.effect,
                subject=change.cause.subject,
                order=float(change.cause.order),
                since=day_of(change.since) or "",
                size_mm=one.named.size_mm,
                rate_mm=None if passes is None else _rate_mm(passes, change.since),
                last_measured_on=day_of(one.last_day) or "",
                day=None if passes is None else day_of(passes.day),
                earliest=None if passes is None else day_of(passes.earliest),
            )


def _rate_mm(passes: LimitCrossing, since: float) -> float:
    """Return by how much a line grows in a month."""
    return passes.limit_mm * _MONTH_DAYS / (passes.day - since)


Progress = Callable[[float, Text], None]
_KEPT: Final = "told"
_FEWEST_VISITS: Final = 2


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A campaign that is not compared, and the sentence that says why."""

    campaign: str
    why: str


@dataclass(frozen=True, slots=True)
class FleetFound:
    """Robots of one type, compared."""

    robot: Robot  # nominal
    account: Account
    campaigns: tuple[str, ...]  # as the fleet has them
    left_out: tuple[LeftOut, ...]
    simulated: bool  # a campaign is

    def last_campaign_of(self, robot: str) -> str:
        """Return the name of a robot's last campaign."""
        fleet = self.account.fleet
        own = np.flatnonzero(fleet.robot == fleet.robots.index(robot))
        return self.campaigns[int(own[np.argmax(fleet.day[own])])]


def fleet_found(
    entries: Sequence[Entry], left_out: Sequence[LeftOut] = (), of_type: str | None = None
) -> FleetFound:
    """Compare the robots of a type; None: all are of one.

    Raises
    ------
    ConfigurationError
        Campaigns are of several types, of fewer than two robots, or no robot was measured twice.
    """
    # Parameters count from a nominal table: those of another type have the same names and mean something
    # else.
    wanted = _type_wanted(of_type, [one.told.robot.name for one in entries])
    among = [one for one in entries if one.told.robot.name == wanted]
    unfit = {one.campaign: why for one, why in unfit_of(among)}
    fit = [one for one in among if one.campaign not in unfit]
    without = [*left_out, *(LeftOut(name, why) for name, why in unfit.items())]
    measured = [
        FleetCampaign(one.stated.robot, one.stated.instrument, float(day.toordinal()), one.told.information)
        for one in fit
        if (day := one.stated.day) is not None
    ]
    _check_enough(measured, without)
    account = account_of(fleet_of(measured), fit[0].told.robot)
    unlike = {one.place: unlike_sentence(one) for one in account.unlike}
    return FleetFound(
        fit[0].told.robot,
        account,
        tuple(one.campaign for place, one in enumerate(fit) if place not in unlike),
        (*without, *(LeftOut(fit[place].campaign, why) for place, why in unlike.items())),
        any(one.told.simulated for one in among),
    )


class FleetArchive:
    """Campaigns of robots, and the folder in which what they tell is kept.

    Parameters
    ----------
    campaigns : sequence of ArchivedCampaign
    visits : mapping of str to Stated, optional
        What a table says of campaigns by their names; it goes before what they say themselves.
    kept : Path, optional
        Nothing is kept without it.
    """

    def __init__(
        self,
        campaigns: Sequence[ArchivedCampaign],
        visits: Mapping[str, Stated] | None = None,
        kept: Path | None = None,
    ) -> None:
        self._campaigns = campaigns
        self._visits = visits or {}
        self._folder = None if kept is None else kept / _KEPT
        self._told: dict[int, CampaignEstimate] = {}  # by the place of the campaign in the archive
        self._failed: dict[int, str] = {}
        self._asked: list[tuple[int, Path | None]] = []
        _check_named(campaigns, self._visits)

    def tell(self, cluster: Cluster, progress: Progress) -> None:
        """Have every campaign tell what it does, once for its data and this version of the program.

        Raises ClusterError where workers are lost for good: what was told is on disk, and the next run goes
        on from there.
        """
        if self._folder is not None:
            self._folder.mkdir(parents=True, exist_ok=True)
        for outcome in cluster.outcomes(tell, self._missing()):
            place, file = self._asked[outcome.number]
            if isinstance(outcome, PartFailure):
                self._failed[place] = outcome.why
            else:
                self._keep(place, outcome.answer, file)
            done = len(self._told) + len(self._failed)
            progress(done / len(self._campaigns), outcome.name)

    def compare(self, of_type: str | None = None) -> FleetFound:
        """Compare the robots of a type, from what their campaigns told; raises as `fleet_found`."""
        entries = [
            Entry(self._campaigns[place].name, self._stated(self._campaigns[place], told), told)
            for place, told in sorted(self._told.items())
        ]
        return fleet_found(entries, self._without_answer(), of_type)

    def _missing(self) -> Iterator[Part[bytes]]:
        for place, campaign in enumerate(self._campaigns):
            try:
                content = campaign.load()
            except TrueposeError as error:
                self._failed[place] = str(error)
                continue
            # By the data and the program alone. Names and days that a table says are no part of it, so a
            # table that is corrected costs no computing.
            file = self._file(content)
            kept = _kept(file)
            if kept is not None:
                self._told[place] = kept
            else:
                self._asked.append((place, file))
                yield Part(campaign.name, content)

    def _file(self, content: bytes) -> Path | None:
        """Return where a campaign's answer is kept: it follows from its data and the program alone."""
        if self._folder is None:
            return None
        of = f"{program()}\n{sha256(content)}"
        return self._folder / f"{hashlib.sha256(of.encode()).hexdigest()[:32]}.told"

    def _keep(self, place: int, answer: bytes, file: Path | None) -> None:
        if file is not None:
            keep_whole(file, answer)
        self._told[place] = summary_from(answer)

    def _stated(self, archived: ArchivedCampaign, told: CampaignEstimate) -> Stated:
        by_table = self._visits.get(archived.name, NOT_STATED)
        return by_table.or_else(told.stated).or_else(archived.stated)

    def _without_answer(self) -> list[LeftOut]:
        return [LeftOut(self._campaigns[place].name, why) for place, why in sorted(self._failed.items())]


def _kept(file: Path | None) -> CampaignEstimate | None:
    """Return what a file has of a campaign; None where it is not there or is torn: it is told again then."""
    if file is None:
        return None
    try:
        return summary_from(file.read_bytes())
    except (FileNotFoundError, DamagedDatabaseError):
        return None


def _check_named(campaigns: Sequence[ArchivedCampaign], visits: Mapping[str, Stated]) -> None:
    unknown = sorted(visits.keys() - {campaign.name for campaign in campaigns})
    if unknown:
        raise ConfigurationError(
            f"The table names campaign {unknown[0]!r}, which is not in the archive; the archive contains, "
            f"for example, {campaigns[0].name!r}."
        )


def _type_wanted(of_type: str | None, names: Sequence[str]) -> str:
    """Return the type to compare; raises ConfigurationError where that is not said."""
    counts = Counter(names)
    listed = ", ".join(f"{name} ({count})" for name, count in sorted(counts.items())) or "none"
    if of_type is not None and of_type not in counts:
        raise ConfigurationError(f"No campaign has robot type {of_type!r}; available types: {listed}.")
    if of_type is None and len(counts) > 1:
        raise ConfigurationError(f"The campaigns are of several types: {listed}. Choose a type with --type.")
    return of_type or next(iter(counts), "")


def _check_enough(measured: Sequence[FleetCampaign], left_out: Sequence[LeftOut]) -> None:
    if not measured:
        raise ConfigurationError(
            f"No campaign can be compared. {left_out[0].campaign}: {left_out[0].why}"
            if left_out
            else "There is no campaign to compare."
        )
    days: dict[str, set[float]] = {}
    for one in measured:
        days.setdefault(one.robot, set()).add(one.day)
    if len(days) > 1 and max(map(len, days.values())) < _FEWEST_VISITS:
        raise ConfigurationError(
            f"{len(days)} robots were measured on one day each. To detect changes, at least one robot must "
            "be measured on two days or more."
        )
