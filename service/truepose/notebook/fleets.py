"""Fleets in a notebook: what robots of one type share, and which of them changes over months."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from truepose.domain.campaign import Campaign as Measured
from truepose.domain.errors import ConfigurationError
from truepose.exchange.results.fleet import shared_parameters
from truepose.fleet import campaigns as measured
from truepose.fleet.campaigns import information_of
from truepose.fleet.changes import Account, RealChange, account_of
from truepose.fleet.outlying_campaigns import OutlyingCampaign
from truepose.fleet.predicted_accuracy import of_a_new_robot
from truepose.fleet.trend import along, passing
from truepose.fleet.trials import Change
from truepose.identification.problem.build import JointPrior
from truepose.messages.message import message
from truepose.notebook import display
from truepose.notebook.campaign import Campaign, campaign_given
from truepose.notebook.display import count_text, frame
from truepose.notebook.inputs import Progress, on_one_thread

if TYPE_CHECKING:
    from pandas import DataFrame

# Robot, instrument, day (a date, or a number of days from any origin), campaign.
Visit: TypeAlias = tuple[str, str, date | float, Campaign | str | Path]

_HEAD = ("what", "cause", "kind", "since", "size, mm", "u", "alternatives")


@dataclass(frozen=True, repr=False)
class Fleet:
    """What the campaigns of robots of one type say.

    Attributes
    ----------
    account : truepose.fleet.changes.Account
        Everything that was found, in stated widths.

    Examples
    --------
    >>> import truepose as tp
    >>> robots, days, folder = ("left", "right"), (0, 30), "docs/examples/campaign"
    >>> fleet = tp.fleet_of([(robot, "tracker", day, folder) for robot in robots for day in days])
    >>> fleet
    Fleet of 2 robots, 1 instrument, 4 campaigns: no significant change
    >>> tp.identify("docs/examples/campaign", fleet=fleet)
    Traceback (most recent call last):
    ...
    truepose.domain.errors.ConfigurationError: The fleet already contains this campaign, which would ...
    """

    account: Account
    _held: tuple[Measured, ...] = ()

    @property
    def changes(self) -> DataFrame:
        """Return one row a named change, the clearest first; raises MissingExtraError.

        What changed (robot, instrument, or the type), its cause, as a line or a step, since which day, its
        size [mm] (RMS of what it moves at the measured configurations) with its standard uncertainty, the
        chance of so much where nothing changes, and what else explains it as well.
        """
        return frame([_row(one) for one in self.account.named])

    def forecast(self, limit_mm: float) -> DataFrame:
        """Return when each change that goes on passes a limit, with the days of 5 % and 95 %."""
        fleet = self.account.fleet
        each = ((one, passing(fleet, one, limit_mm)) for one in self.account.named)
        return frame([
            {"what": _what(one.change), "cause": _cause(one.change), "day": found.day}
            | {"earliest": found.earliest, "latest": found.latest}
            for one, found in each
            if found is not None
        ])

    def course(self, number: int) -> DataFrame:
        """Return how a named change (1 for the first) went: one row a campaign or day after the first.

        `size_mm` is by how much it is seen to differ from the first, along the change as it was named,
        and `u_mm` its standard uncertainty. Raises ConfigurationError where there is no such change.
        """
        told = self.account.named[number - 1 : number] if number >= 1 else ()
        if not told:
            raise ConfigurationError(
                f"There is no change {number}: the fleet has {count_text(len(self.account.named), 'change')}."
            )
        found = along(self.account, told[0])
        return frame({"day": found.day, "size_mm": found.size_mm, "u_mm": found.u_mm})

    def to_frame(self) -> DataFrame:
        """Return one row a parameter: the type's value, how robots differ, and how well that is known.

        In the units that files use: mm, deg, rad/(N*mm).
        """
        return frame([one.printed() for one in shared_parameters(self.account)])

    @cached_property
    def belief(self) -> JointPrior:
        """What is believed of a further robot of the type: `tp.identify(campaign, fleet=fleet)` takes it."""
        return of_a_new_robot(self.account)

    def believed_of(self, campaign: Measured) -> JointPrior:
        """Return what is believed of the robot of a further campaign.

        Raises ConfigurationError where the robot is of another type, or the fleet has the campaign.
        """
        _require_one_type((*self._held, campaign))
        if any(_same_readings(one, campaign) for one in self._held):
            raise ConfigurationError(
                "The fleet already contains this campaign, which would then count twice. Give another "
                "campaign, or omit the fleet."
            )
        return self.belief

    def __repr__(self) -> str:
        fleet = self.account.fleet
        sizes = (
            count_text(len(fleet.robots), "robot"),
            count_text(len(fleet.instruments), "instrument"),
            count_text(len(fleet.day), "campaign"),
        )
        named = "; ".join(f"{_what(one.change)}: {_cause(one.change)}" for one in self.account.named)
        told = [named or "no significant change", *(_unlike(one) for one in self.account.unlike)]
        return f"Fleet of {', '.join(sizes)}: {'; '.join(told)}"

    def _repr_html_(self) -> str:
        rows = [tuple(str(value) for value in _row(one).values()) for one in self.account.named]
        shown = [(*row[:4], *row[4:6], row[7]) for row in rows]
        table = display.table("Significant changes", _HEAD, shown, numbers_from=4)
        return display.page(display.paragraphs((repr(self),)), *([table] if shown else []))


@on_one_thread
def fleet_of(campaigns: Iterable[Visit], progress: Progress | None = None) -> Fleet:
    """Say what robots of one type share, which of them changes, since when, and whether it is the instrument.

    Parameters
    ----------
    campaigns : iterable of (robot, instrument, day, campaign)
        Names, a date or a number of days, and a campaign or its path; two robots at least.
    progress : callable, optional
        Told the fraction done (0 to 1) and what is being done.

    Returns
    -------
    Fleet

    Raises
    ------
    ConfigurationError
        There are fewer than two robots, they are of several types, or what is given is not a campaign.
    InputFileError
        A folder or zip cannot be read, with file, line and column.

    Examples
    --------
    >>> import truepose as tp
    >>> tp.fleet_of([("left", "tracker", 0, "docs/examples/campaign")])
    Traceback (most recent call last):
    ...
    truepose.domain.errors.ConfigurationError: A fleet needs at least two robots of one type; ...
    """
    visits = [(*visit[:3], campaign_given(visit[3]).data) for visit in campaigns]
    held = tuple(data for *_, data in visits)
    _require_one_type(held)
    told = []
    for number, (robot, instrument, day, data) in enumerate(visits):
        if progress is not None:
            progress(0.9 * number / len(visits), message("job.doing.identifying"))
        told.append(measured.FleetCampaign(robot, instrument, _days(day), information_of(data)))
    together = measured.fleet_of(told)
    if progress is not None:
        progress(0.9, message("job.doing.comparing"))
    return Fleet(account_of(together, held[-1].robot), held)


def _require_one_type(campaigns: Sequence[Measured]) -> None:
    types = dict.fromkeys(campaign.robot.name for campaign in campaigns)
    if len(types) > 1:
        raise ConfigurationError(
            f"A fleet consists of robots of one type, but these are {', '.join(types)}: "
            "compare each type separately."
        )


def _same_readings(one: Measured, other: Measured) -> bool:
    mine, theirs = one.readings, other.readings
    return mine is not None and theirs is not None and np.array_equal(mine.observed_mm, theirs.observed_mm)


def _days(day: date | float) -> float:
    return float(day.toordinal()) if isinstance(day, date) else float(day)


def _row(named: RealChange) -> dict[str, object]:
    change = named.change
    return {
        "what": _what(change),
        "cause": _cause(change),
        "kind": change.kind,
        "since": change.since,
        "size_mm": round(named.size_mm, 4),
        "u_mm": round(named.size_u_mm, 4),
        "chance": named.trial.chance,
        "or_else": "; ".join(
            f"{_what(one.change)}: {_cause(one.change)}, {one.change.kind}" for one in named.rivals
        ),
    }


def _unlike(one: OutlyingCampaign) -> str:
    match = f"matches {one.resembles}" if one.resembles else "matches no robot in the fleet"
    campaign = f"the campaign of {one.robot} on day {one.day:g}"
    return f"{campaign} does not match its other campaigns, {match}, and is left out"


def _what(change: Change) -> str:
    return change.of or "the type"


def _cause(change: Change) -> str:
    cause = change.cause
    order = f", {cause.order:g} per turn" if cause.order else ""
    return f"{cause.effect} of {cause.subject}{order}"
