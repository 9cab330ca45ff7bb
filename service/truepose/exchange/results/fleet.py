"""What the campaigns of robots of one type say, as a document."""

import math
from collections.abc import Iterator, Sequence
from datetime import date
from typing import Self

import numpy as np
from pydantic import Field

from truepose.domain.robot import Robot
from truepose.domain.sentences import Sentence
from truepose.exchange.models.document import file_factor, file_unit
from truepose.exchange.outgoing import Quantity
from truepose.exchange.results.document_base import Document, Spoken
from truepose.fleet.answer.due import Due, Why, due
from truepose.fleet.answer.grown import Grown
from truepose.fleet.answer.sentences import (
    change_said,
    compared,
    day_of,
    drift_um_per_m,
    grown_said,
    headline,
    least_said,
    new_robot_said,
    next_said,
    passing_said,
    scatter_said,
    told_of,
    why_said,
)
from truepose.fleet.causes import AgeingCause
from truepose.fleet.changes import Account, Named
from truepose.fleet.components import uncertainties
from truepose.fleet.course import along
from truepose.fleet.forecast import Passing, concerned, passing
from truepose.fleet.least import Least, least_of_instruments, least_of_robots
from truepose.fleet.promise import Promise
from truepose.fleet.trials import Kind, Scope, Trial
from truepose.words.catalogue import english


class CauseDocument(Document):
    """What changes in a robot or an instrument."""

    effect: str
    subject: str
    waves_per_turn: float | None = Field(description="Null: it is no wave.")

    @classmethod
    def of_cause(cls, cause: AgeingCause) -> Self:
        """Return a cause."""
        return cls(effect=cause.effect, subject=cause.subject, waves_per_turn=cause.order or None)


class RivalDocument(Document):
    """What explains a change as well, at odds of no worse than twenty to one."""

    scope: Scope
    what: str = Field(description="Serial number of a robot or an instrument; empty: the type.")
    cause: CauseDocument
    kind: Kind
    since: date
    sentence: Spoken

    @classmethod
    def of_trial(cls, trial: Trial) -> Self:
        """Return a rival."""
        change = trial.change
        return cls(
            scope=change.scope,
            what=change.of,
            cause=CauseDocument.of_cause(change.cause),
            kind=change.kind,
            since=_date(change.since),
            sentence=english(change_said(change)),
        )


class PassingDocument(Document):
    """When a limit is passed if a change goes on as it did; null: not in the reach of a calendar."""

    limit_mm: float
    day: str | None = Field(description="Half of the probability is before it.")
    earliest: str | None = Field(description="5 %.")
    latest: str | None = Field(description="95 %; null: perhaps never.")
    sentence: Spoken


class AlongDocument(Document):
    """How far a change had come on each day after the first."""

    day: date
    size_mm: Quantity
    standard_uncertainty_mm: Quantity


class ChangeDocument(RivalDocument):
    """A change that is beyond chance."""

    size_mm: Quantity = Field(description="Root mean square of what it moves at the measured configurations.")
    standard_uncertainty_mm: Quantity
    chance: Quantity = Field(description="Of so much where nothing changes, of this one try.")
    rivals: list[RivalDocument]
    passes: PassingDocument | None = Field(description="Null: it does not go on, as a step.")
    course: list[AlongDocument]
    sentences: list[Spoken]

    @classmethod
    def of_named(cls, account: Account, named: Named, limit_mm: float) -> Self:
        """Return a change with everything that is said of it."""
        passes, told = passing(account.fleet, named, limit_mm), along(account, named)
        course = zip(told.day.tolist(), told.size_mm.tolist(), told.u_mm.tolist(), strict=True)
        return cls.of(
            RivalDocument.of_trial(named.trial),
            size_mm=named.size_mm,
            standard_uncertainty_mm=named.size_u_mm,
            chance=named.trial.chance,
            rivals=[RivalDocument.of_trial(one) for one in named.rivals],
            passes=None if passes is None else _passing(account, named, passes),
            course=[
                AlongDocument(day=_date(day), size_mm=size, standard_uncertainty_mm=u)
                for day, size, u in course
            ],
            sentences=list(told_of(account, named, passes)),
        )


class DueDocument(Document):
    """A robot, and what speaks for measuring it."""

    robot: str
    why: Why
    last_measured_on: date
    instrument: str | None = Field(description="That tells its change from a rival; null: any.")
    sentence: Spoken

    @classmethod
    def of_due(cls, one: Due, limit_mm: float) -> Self:
        """Return a robot."""
        return cls.of(
            one,
            last_measured_on=_date(one.last_day),
            instrument=one.instrument or None,
            sentence=why_said(one, limit_mm),
        )


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
    size_mm: Quantity | None = Field(description="In every robot measured twice; null: in one at no size.")
    best_mm: Quantity | None = Field(description="In the robot in which it shows best.")


class LeastDriftDocument(Document):
    """From which size on a drift of an instrument would have been shown with 95 %."""

    instrument: str
    days: Quantity = Field(description="From its first campaign to its last, over which it drifts.")
    size_mm: Quantity | None = Field(description="At what it measured; null: at no size.")
    um_per_m: Quantity | None = Field(description="Of all lengths.")


class NewRobotDocument(Document):
    """What a further robot of the type needs, before it is measured: mean errors over the work volume."""

    configurations: int
    mean_mm: Quantity = Field(description="Promised with what the type says.")
    interval_90_mm: list[Quantity] = Field(description="Nine of ten robots have their mean within.")
    without_type_mm: Quantity = Field(description="As many of the same parameters, without the type.")
    needed_without_type: int | None = Field(description="For the same mean; null: more than 100.")
    usual_configurations: int
    usual_mm: Quantity = Field(description="Promised by the usual effects of a robot of no known type.")
    sentence: Spoken

    @classmethod
    def of_promise(cls, found: Promise) -> Self:
        """Return what is promised."""
        return cls.of(
            found,
            configurations=found.pooled.n,
            mean_mm=found.pooled.mean_mm,
            interval_90_mm=list(found.pooled.interval_90_mm),
            without_type_mm=found.same_mm,
            needed_without_type=found.needed,
            usual_configurations=found.alone.n,
            usual_mm=found.alone.mean_mm,
            sentence=new_robot_said(found),
        )


class GrownDocument(Document):
    """What a check says of one cause."""

    cause: CauseDocument
    size_mm: Quantity
    standard_uncertainty_mm: Quantity | None = Field(description="Null: the check does not see it.")
    chance: Quantity = Field(description="Of so much where it has not grown, of this one cause.")
    told: bool = Field(description="Beyond chance, at a level of 5 % over all causes together.")
    would_show_mm: Quantity | None = Field(description="From which size on, with 95 %; null: at none.")


class CheckedDocument(Document):
    """What a check of one robot says."""

    robot: str
    causes: list[GrownDocument] = Field(description="The least likely to be chance first.")
    sentences: list[Spoken]

    @classmethod
    def of_robot(cls, robot: str, found: Sequence[Grown]) -> Self:
        """Return what was found."""
        causes = [
            GrownDocument(
                cause=CauseDocument.of_cause(one.cause),
                size_mm=one.size_mm,
                standard_uncertainty_mm=_finite(one.u_mm),
                chance=one.chance,
                told=one.is_told,
                would_show_mm=_finite(one.least_mm),
            )
            for one in found
        ]
        return cls(robot=robot, causes=causes, sentences=list(map(english, grown_said(robot, found))))


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
    new_robot: Promise | None = None,
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
        would_show=[_least(one) for one in least_of_robots(account) if one.of],
        drifts_would_show=list(_least_drifts(account)),
        next=[DueDocument.of_due(one, limit_mm) for one in due(account, limit_mm)],
        new_robot=None if new_robot is None else NewRobotDocument.of_promise(new_robot),
        checked=checked,
        type=list(shared(account)),
        left_out=list(left_out),
        sentences=[
            compared(account),
            headline(account),
            *least_said(account),
            *_next(account, limit_mm),
            *scatter_said(account),
        ],
    )


def _next(account: Account, limit_mm: float) -> list[Sentence]:
    return [next_said(one, limit_mm) for one in due(account, limit_mm)[:1]]


def _least(one: Least) -> LeastDocument:
    return LeastDocument(
        cause=CauseDocument.of_cause(one.cause),
        size_mm=_finite(float(one.size_mm.max())),
        best_mm=_finite(float(one.size_mm.min())),
    )


def _least_drifts(account: Account) -> Iterator[LeastDriftDocument]:
    found = least_of_instruments(account)
    for name, size_mm, days in zip(found.of, found.size_mm.tolist(), found.days.tolist(), strict=True):
        um_per_m = drift_um_per_m(account.fleet, size_mm) if math.isfinite(size_mm) else None
        yield LeastDriftDocument(instrument=name, days=days, size_mm=_finite(size_mm), um_per_m=um_per_m)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def shared(account: Account) -> list[SharedDocument]:
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


def _passing(account: Account, named: Named, passes: Passing) -> PassingDocument:
    last = float(account.fleet.day[concerned(account.fleet, named)].max())
    return PassingDocument(
        limit_mm=passes.limit_mm,
        day=day_of(passes.day),
        earliest=day_of(passes.earliest),
        latest=day_of(passes.latest),
        sentence=english(passing_said(passes, last)),
    )


def _date(day: float) -> date:
    return date.fromordinal(int(day))
