"""What the campaigns of robots of one type say, as a document."""

import math
from collections.abc import Iterator, Sequence
from datetime import date
from typing import Annotated, Self

import numpy as np
from pydantic import Field

from truepose.domain.robot import Robot
from truepose.exchange.models.document import file_factor, file_unit
from truepose.exchange.results.document import Document, FieldSource, Quantity, Spoken, null_if_empty
from truepose.fleet.changes import Account, RealChange
from truepose.fleet.interim_check import CauseGrowth
from truepose.fleet.minimum_detectable_change import least_of_instruments, least_of_robots
from truepose.fleet.mixed_model import uncertainties
from truepose.fleet.outcome import fleet_outcome
from truepose.fleet.predicted_accuracy import PredictedAccuracy
from truepose.fleet.sentences import (
    change_said,
    change_sentences,
    comparison_sentence,
    day_of,
    drift_um_per_m,
    grown_said,
    headline,
    least_said,
    new_robot_said,
    next_said,
    passing_said,
    scatter_said,
    why_said,
)
from truepose.fleet.trend import LimitCrossing, Why, affected_campaigns, along, due, passing
from truepose.fleet.trials import Kind, Scope
from truepose.messages.message import Message


def _date(day: float) -> date:
    return date.fromordinal(int(day))


class CauseDocument(Document):
    """Cause of a change in a robot or an instrument."""

    effect: str
    subject: str
    waves_per_turn: Annotated[float | None, null_if_empty("order")] = Field(
        description="Periods per turn; null if the error is not periodic."
    )


class RivalDocument(Document):
    """An alternative explanation of a change, with odds of at most 20:1 against it."""

    scope: Annotated[Scope, FieldSource("change.scope")]
    what: Annotated[str, FieldSource("change.of")] = Field(
        description="Serial number of the robot or instrument; empty for the robot type."
    )
    cause: Annotated[CauseDocument, FieldSource("change.cause")]
    kind: Annotated[Kind, FieldSource("change.kind")]
    since: Annotated[date, FieldSource("change.since", _date)]
    sentence: Annotated[Spoken, FieldSource("change", change_said)]


class PassingDocument(Document):
    """Forecast of when a limit is exceeded if the change continues; dates beyond the calendar are null."""

    limit_mm: float
    day: Annotated[str | None, FieldSource("day", day_of)] = Field(description="Median date.")
    earliest: Annotated[str | None, FieldSource("earliest", day_of)] = Field(
        description="5 % quantile of the date."
    )
    latest: Annotated[str | None, FieldSource("latest", day_of)] = Field(
        description="95 % quantile of the date; null if the limit may never be exceeded."
    )
    sentence: Spoken


class AlongDocument(Document):
    """Size of a change on each measuring day after the first."""

    day: date
    size_mm: Quantity
    standard_uncertainty_mm: Quantity


class ChangeDocument(RivalDocument):
    """A statistically significant change."""

    size_mm: Quantity = Field(
        description="RMS displacement caused by the change at the measured configurations."
    )
    standard_uncertainty_mm: Annotated[Quantity, FieldSource("size_u_mm")]
    chance: Annotated[Quantity, FieldSource("trial.chance")] = Field(
        description="Probability of a change this large by chance, in this single test."
    )
    rivals: list[RivalDocument]
    passes: PassingDocument | None = Field(
        description="Forecast of when the limit is exceeded; null if the change does not continue, such as "
        "a step."
    )
    course: list[AlongDocument]
    sentences: list[Spoken]

    @classmethod
    def of_named(cls, account: Account, named: RealChange, limit_mm: float) -> Self:
        """Return a change with everything that is said of it."""
        passes, told = passing(account.fleet, named, limit_mm), along(account, named)
        course = zip(told.day.tolist(), told.size_mm.tolist(), told.u_mm.tolist(), strict=True)
        return cls.of(
            named,
            passes=None if passes is None else _passing(account, named, passes),
            course=[
                AlongDocument(day=_date(day), size_mm=size, standard_uncertainty_mm=u)
                for day, size, u in course
            ],
            sentences=list(change_sentences(account, named, passes)),
        )


class DueDocument(Document):
    """A robot, with the reason for measuring it."""

    robot: str
    why: Why
    last_measured_on: Annotated[date, FieldSource("last_day", _date)]
    instrument: Annotated[str | None, null_if_empty("instrument")] = Field(
        description="Instrument that would rule out an alternative explanation; null if any instrument "
        "will do."
    )
    sentence: Spoken


class SharedDocument(Document):
    """A parameter common to all robots of the type, with its unit."""

    name: str
    effect: str
    unit: str
    value: Quantity
    between_robots: Quantity = Field(description="Standard deviation between robots.")
    between_robots_u: Quantity = Field(description="Standard uncertainty of `between_robots`.")


class LeastDocument(Document):
    """Minimum detectable size (95 %) of a cause that grows from the first campaign on."""

    cause: CauseDocument
    size_mm: Annotated[Quantity, FieldSource("size_mm", np.max)] = Field(
        description="Size detectable in every robot measured twice; null if not detectable in at least one "
        "of them."
    )
    best_mm: Annotated[Quantity, FieldSource("size_mm", np.min)] = Field(
        description="Size detectable in the most sensitive robot."
    )


class LeastDriftDocument(Document):
    """Minimum detectable drift (95 %) of an instrument."""

    instrument: str
    days: Quantity = Field(
        description="Days from the first to the last campaign of the instrument, over which the drift is "
        "assumed."
    )
    size_mm: Quantity = Field(
        description="Detectable displacement of the measured positions; null if no drift is detectable."
    )
    um_per_m: Quantity = Field(description="Detectable scale error, relative to every measured length.")


class NewRobotDocument(Document):
    """Measurements needed for a further robot of the type: predicted mean errors over the work volume."""

    configurations: Annotated[int, FieldSource("pooled.n")]
    mean_mm: Annotated[Quantity, FieldSource("pooled.mean_mm")] = Field(
        description="Predicted mean error with prior knowledge of the type."
    )
    interval_90_mm: Annotated[list[Quantity], FieldSource("pooled.interval_90_mm")] = Field(
        description="Interval that contains the mean error of nine robots out of ten."
    )
    without_type_mm: Annotated[Quantity, FieldSource("same_mm")] = Field(
        description="Predicted mean error with the same number of configurations and parameters, but "
        "without the type."
    )
    needed_without_type: Annotated[int | None, FieldSource("needed")] = Field(
        description="Configurations needed for the same mean error without the type; null if more than 100."
    )
    usual_configurations: Annotated[int, FieldSource("alone.n")]
    usual_mm: Annotated[Quantity, FieldSource("alone.mean_mm")] = Field(
        description="Predicted mean error with the default effects, for a robot of unknown type."
    )
    sentence: Annotated[Spoken, FieldSource("", new_robot_said)]


class GrownDocument(Document):
    """Result of an interim check for one cause."""

    cause: CauseDocument
    size_mm: Quantity
    standard_uncertainty_mm: Annotated[Quantity, FieldSource("u_mm")] = Field(
        description="Standard uncertainty of the size; null if the check cannot detect the cause."
    )
    chance: Quantity = Field(
        description="Probability of a size this large by chance if the cause has not grown, in this single "
        "test."
    )
    told: Annotated[bool, FieldSource("is_told")] = Field(
        description="True if significant at the 5 % level over all causes together."
    )
    would_show_mm: Annotated[Quantity, FieldSource("least_mm")] = Field(
        description="Minimum detectable size (95 %); null if not detectable at any size."
    )


class CheckedDocument(Document):
    """Result of an interim check of one robot."""

    robot: str
    causes: list[GrownDocument] = Field(description="Causes, most significant first.")
    sentences: list[Spoken]

    @classmethod
    def of_robot(cls, robot: str, found: Sequence[CauseGrowth]) -> Self:
        """Return what was found."""
        return cls.of(robot=robot, causes=list(found), sentences=grown_said(robot, found))


class LeftOutDocument(Document):
    """A campaign excluded from the comparison."""

    campaign: str
    why: str


class FleetDocument(Document):
    """Result of `truepose fleet --json`."""

    outcome: Spoken = Field(
        description="Summary: robots within the limit, the largest change, pass or fail or what is missing "
        "for it."
    )
    robot: str = Field(description="Robot type.")
    robots: list[str]
    instruments: list[str]
    campaigns: int
    first: date
    last: date
    simulated: bool
    limit_mm: float
    tried: int = Field(
        description="Number of possible changes of robots, type and instruments that were tested."
    )
    scatter: Quantity = Field(
        description="Ratio of the scatter between campaigns to that expected from their readings; 1 if as "
        "expected."
    )
    changes: list[ChangeDocument]
    would_show: list[LeastDocument] = Field(
        description="Minimum detectable changes; a smaller change may be present without being detected."
    )
    drifts_would_show: list[LeastDriftDocument]
    next: list[DueDocument] = Field(description="All robots, in the order in which to measure them next.")
    new_robot: NewRobotDocument | None = Field(
        None, description="Forecast for a new robot; only with --new or --pooled."
    )
    checked: CheckedDocument | None = Field(
        None, description="Result of the interim check; only with --checked."
    )
    type: list[SharedDocument] = Field(description="Parameters common to all robots of the type.")
    left_out: list[LeftOutDocument]
    sentences: list[Spoken]


def fleet_document(
    account: Account,
    robot: Robot,
    limit_mm: float,
    left_out: Sequence[object] = (),
    *,
    simulated: bool = False,
    new_robot: PredictedAccuracy | None = None,
    checked: CheckedDocument | None = None,
) -> FleetDocument:
    """Return the document of a fleet whose days are those of the calendar (`date.toordinal`)."""
    fleet = account.fleet
    return FleetDocument.of(
        fleet,
        outcome=fleet_outcome(account, limit_mm),
        robot=robot.name,
        campaigns=len(fleet.day),
        first=_date(fleet.day.min()),
        last=_date(fleet.day.max()),
        simulated=simulated,
        limit_mm=limit_mm,
        tried=account.tried,
        scatter=float(np.sqrt(account.birge_ratio)),
        changes=[ChangeDocument.of_named(account, one, limit_mm) for one in account.named],
        would_show=[one for one in least_of_robots(account) if one.of],
        drifts_would_show=list(_least_drifts(account)),
        next=[DueDocument.of(one, sentence=why_said(one, limit_mm)) for one in due(account, limit_mm)],
        new_robot=new_robot,
        checked=checked,
        type=list(shared_parameters(account)),
        left_out=list(left_out),
        sentences=[
            comparison_sentence(account),
            headline(account),
            *least_said(account),
            *_next(account, limit_mm),
            *scatter_said(account),
        ],
    )


def _next(account: Account, limit_mm: float) -> list[Message]:
    return [next_said(one, limit_mm) for one in due(account, limit_mm)[:1]]


def _least_drifts(account: Account) -> Iterator[LeastDriftDocument]:
    found = least_of_instruments(account)
    for name, size_mm, days in zip(found.of, found.size_mm.tolist(), found.days.tolist(), strict=True):
        um_per_m = drift_um_per_m(account.fleet, size_mm) if math.isfinite(size_mm) else None
        yield LeastDriftDocument(instrument=name, days=days, size_mm=size_mm, um_per_m=um_per_m)


def shared_parameters(account: Account) -> list[SharedDocument]:
    """Return what the robots have in common, parameter by parameter."""
    fleet, estimated = account.fleet, account.estimated
    own = slice(len(fleet.specs))
    spread = np.sqrt(estimated.variances.robot)
    columns = zip(
        fleet.specs,
        fleet.owners,
        (fleet.means + fleet.widths * estimated.posterior.shared[own]).tolist(),
        (fleet.widths * spread).tolist(),
        (fleet.widths * uncertainties(estimated) / (2.0 * spread)).tolist(),
        strict=True,
    )
    return [
        SharedDocument(
            name=spec.name,
            effect=owner,
            unit=file_unit(spec.unit),
            value=value * file_factor(spec.unit),
            between_robots=between * file_factor(spec.unit),
            between_robots_u=u * file_factor(spec.unit),
        )
        for spec, owner, value, between, u in columns
    ]


def _passing(account: Account, named: RealChange, passes: LimitCrossing) -> PassingDocument:
    last = float(account.fleet.day[affected_campaigns(account.fleet, named)].max())
    return PassingDocument.of(passes, sentence=passing_said(passes, last))
