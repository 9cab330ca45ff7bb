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
    """What changes in a robot or an instrument."""

    effect: str
    subject: str
    waves_per_turn: Annotated[float | None, null_if_empty("order")] = Field(
        description="Null: it is no wave."
    )


class RivalDocument(Document):
    """What explains a change as well, at odds of no worse than twenty to one."""

    scope: Annotated[Scope, FieldSource("change.scope")]
    what: Annotated[str, FieldSource("change.of")] = Field(
        description="Serial number of a robot or an instrument; empty: the type."
    )
    cause: Annotated[CauseDocument, FieldSource("change.cause")]
    kind: Annotated[Kind, FieldSource("change.kind")]
    since: Annotated[date, FieldSource("change.since", _date)]
    sentence: Annotated[Spoken, FieldSource("change", change_said)]


class PassingDocument(Document):
    """When a limit is passed if a change goes on as it did; null: not in the reach of a calendar."""

    limit_mm: float
    day: Annotated[str | None, FieldSource("day", day_of)] = Field(
        description="Half of the probability is before it."
    )
    earliest: Annotated[str | None, FieldSource("earliest", day_of)] = Field(description="5 %.")
    latest: Annotated[str | None, FieldSource("latest", day_of)] = Field(
        description="95 %; null: perhaps never."
    )
    sentence: Spoken


class AlongDocument(Document):
    """How far a change had come on each day after the first."""

    day: date
    size_mm: Quantity
    standard_uncertainty_mm: Quantity


class ChangeDocument(RivalDocument):
    """A change that is beyond chance."""

    size_mm: Quantity = Field(description="Root mean square of what it moves at the measured configurations.")
    standard_uncertainty_mm: Annotated[Quantity, FieldSource("size_u_mm")]
    chance: Annotated[Quantity, FieldSource("trial.chance")] = Field(
        description="Of so much where nothing changes, of this one try."
    )
    rivals: list[RivalDocument]
    passes: PassingDocument | None = Field(description="Null: it does not go on, as a step.")
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
    """A robot, and what speaks for measuring it."""

    robot: str
    why: Why
    last_measured_on: Annotated[date, FieldSource("last_day", _date)]
    instrument: Annotated[str | None, null_if_empty("instrument")] = Field(
        description="That tells its change from a rival; null: any."
    )
    sentence: Spoken


class SharedDocument(Document):
    """A parameter as the type has it, in the unit that it names."""

    name: str
    effect: str
    unit: str
    value: Quantity
    between_robots: Quantity = Field(description="Standard deviation from robot to robot.")
    between_robots_u: Quantity = Field(description="How well that is known.")


class LeastDocument(Document):
    """From which size on a cause that grows from the first campaign on would have been shown with 95 %."""

    cause: CauseDocument
    size_mm: Annotated[Quantity, FieldSource("size_mm", np.max)] = Field(
        description="In every robot measured twice; null: in one at no size."
    )
    best_mm: Annotated[Quantity, FieldSource("size_mm", np.min)] = Field(
        description="In the robot in which it shows best."
    )


class LeastDriftDocument(Document):
    """From which size on a drift of an instrument would have been shown with 95 %."""

    instrument: str
    days: Quantity = Field(description="From its first campaign to its last, over which it drifts.")
    size_mm: Quantity = Field(description="At what it measured; null: at no size.")
    um_per_m: Quantity = Field(description="Of all lengths.")


class NewRobotDocument(Document):
    """What a further robot of the type needs, before it is measured: mean errors over the work volume."""

    configurations: Annotated[int, FieldSource("pooled.n")]
    mean_mm: Annotated[Quantity, FieldSource("pooled.mean_mm")] = Field(
        description="Promised with what the type says."
    )
    interval_90_mm: Annotated[list[Quantity], FieldSource("pooled.interval_90_mm")] = Field(
        description="Nine of ten robots have their mean within."
    )
    without_type_mm: Annotated[Quantity, FieldSource("same_mm")] = Field(
        description="As many of the same parameters, without the type."
    )
    needed_without_type: Annotated[int | None, FieldSource("needed")] = Field(
        description="For the same mean; null: more than 100."
    )
    usual_configurations: Annotated[int, FieldSource("alone.n")]
    usual_mm: Annotated[Quantity, FieldSource("alone.mean_mm")] = Field(
        description="Promised by the usual effects of a robot of no known type."
    )
    sentence: Annotated[Spoken, FieldSource("", new_robot_said)]


class GrownDocument(Document):
    """What a check says of one cause."""

    cause: CauseDocument
    size_mm: Quantity
    standard_uncertainty_mm: Annotated[Quantity, FieldSource("u_mm")] = Field(
        description="Null: the check does not see it."
    )
    chance: Quantity = Field(description="Of so much where it has not grown, of this one cause.")
    told: Annotated[bool, FieldSource("is_told")] = Field(
        description="Beyond chance, at a level of 5 % over all causes together."
    )
    would_show_mm: Annotated[Quantity, FieldSource("least_mm")] = Field(
        description="From which size on, with 95 %; null: at none."
    )


class CheckedDocument(Document):
    """What a check of one robot says."""

    robot: str
    causes: list[GrownDocument] = Field(description="The least likely to be chance first.")
    sentences: list[Spoken]

    @classmethod
    def of_robot(cls, robot: str, found: Sequence[CauseGrowth]) -> Self:
        """Return what was found."""
        return cls.of(robot=robot, causes=list(found), sentences=grown_said(robot, found))


class LeftOutDocument(Document):
    """A campaign that is not compared."""

    campaign: str
    why: str


class FleetDocument(Document):
    """What `truepose fleet --json` prints."""

    robot: str = Field(description="The type.")
    robots: list[str]
    instruments: list[str]
    campaigns: int
    first: date
    last: date
    simulated: bool
    limit_mm: float
    tried: int = Field(description="Ways in which robots, type and instruments may change.")
    scatter: Quantity = Field(description="Of campaigns, over what their readings say; 1: as they say.")
    changes: list[ChangeDocument]
    would_show: list[LeastDocument] = Field(description="A change smaller than that may be there unseen.")
    drifts_would_show: list[LeastDriftDocument]
    next: list[DueDocument] = Field(description="Every robot, the one to be measured next first.")
    new_robot: NewRobotDocument | None = Field(None, description="Asked by --new or --pooled.")
    checked: CheckedDocument | None = Field(None, description="Asked by --checked.")
    type: list[SharedDocument] = Field(description="What robots of the type have in common.")
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
