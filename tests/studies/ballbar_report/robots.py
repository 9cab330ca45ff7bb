"""One robot, measured with the ballbar and with the tracker, identified by each, judged by the truth."""

import math
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from tests.studies.ballbar_report.session import Session, record_session, without_noise
from tests.studies.diagnosis_report.recorder import Recorder, running_recorder
from truepose.domain.arrays import FloatArray
from truepose.domain.errors import TrueposeError
from truepose.domain.identification import Anchor, Model
from truepose.identification import identify, predict
from truepose.identification.model.estimates import identified_anchors
from truepose.identification.thesis_procedure import THESIS_EFFECTS, positions_from_legs
from truepose.kinematics.frames import rigid_alignment

_SAME_MODEL: Final = ("base", "geometry", "compliance")  # the 31 parameters of the ballbar's own model
_BASE: Final = "base"  # lengths alone do not see it: its uncertainty is that of the set-ups


@dataclass(frozen=True, slots=True)
class Robot:
    """Which robot is measured in which kind of session."""

    scenario: str
    kind: str  # key of a plan
    plan: Path
    seed: int
    validation: int  # tracker positions at which errors are judged
    coverage: bool = False  # whether the stated uncertainties are judged as well


@dataclass(frozen=True, slots=True)
class TrueError:
    """Mean true errors of a model [mm]."""

    tied_mm: float  # in the world; for a ballbar the cups, where they truly are, tie it
    aligned_mm: float  # after the best rigid alignment


@dataclass(frozen=True, slots=True)
class Stated:
    """What a model states of itself against the truth."""

    scores: tuple[float, ...]  # (found less true) over the stated uncertainty, each parameter of the arm
    tied_mm: float  # RMS error per axis of predicted positions, tied to the true cups
    world_mm: float  # ... in the world as the model has it, which lengths alone leave open
    uncertainty_mm: float  # RMS of what `predict` states of them


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one robot; None where an identification gave no model."""

    scenario: str
    kind: str
    seed: int
    poses: int = 0
    out_of_range: int = 0  # legs
    ballbar: TrueError | None = None
    tracker: TrueError | None = None
    thesis: TrueError | None = None  # its procedure with its parameters
    thesis_same_model: TrueError | None = None  # its procedure with the ballbar's own
    lost: int = 0  # configurations without a pose in the thesis' procedure
    no_thesis: str = ""  # why its procedure cannot be applied
    stated: Stated | None = None
    fault: str = ""


def compare_robots(robots: tuple[Robot, ...]) -> tuple[Outcome, ...]:
    """Compare robots one after the other with a recorder of their own.

    Raises
    ------
    RecorderFailedError
        A session cannot be recorded.
    """
    with tempfile.TemporaryDirectory() as folder, running_recorder() as recorder:
        return tuple(_compared(robot, recorder, Path(folder) / "session") for robot in robots)


def _compared(robot: Robot, recorder: Recorder, folder: Path) -> Outcome:
    session = record_session(recorder, robot.scenario, robot.seed, robot.plan, folder, robot.validation)
    outcome = Outcome(robot.scenario, robot.kind, robot.seed, session.poses, session.out_of_range)
    try:
        return compared(outcome, session, coverage=robot.coverage)
    except Exception as error:  # one of many: the report says which failed instead of losing the others
        return replace(outcome, fault=f"{type(error).__name__}: {error}")


def compared(outcome: Outcome, session: Session, *, coverage: bool = False) -> Outcome:
    """Return the outcome with the errors of every identification of a session."""
    model, tracker = identify(session.ballbar).model, identify(session.tracker).model
    outcome = replace(
        outcome,
        ballbar=None if model is None else _true_error(model, session, identified_anchors(model)),
        tracker=None if tracker is None else _true_error(tracker, session, ()),
        stated=_stated(model, session) if coverage and model is not None else None,
    )
    try:
        positions = positions_from_legs(session.ballbar)
    except TrueposeError as error:
        return replace(outcome, no_thesis=str(error))
    old, same = (identify(positions.campaign, effects).model for effects in (THESIS_EFFECTS, _SAME_MODEL))
    return replace(
        outcome,
        thesis=None if old is None else _true_error(old, session, positions.cups),
        thesis_same_model=None if same is None else _true_error(same, session, positions.cups),
        lost=len(positions.lost),
    )


def _true_error(model: Model, session: Session, cups: tuple[Anchor, ...]) -> TrueError:
    """Judge a model; its `cups`, where there are any, tie it to the world."""
    predicted, _ = predict(model, session.readings.stops, session.readings.nest)
    tied = _tied(predicted, cups, session) if cups else predicted
    true = session.validation_mm
    return TrueError(_mean_off(tied, true), _mean_off(_moved(predicted, predicted, true), true))


def _tied(points_mm: FloatArray, cups: tuple[Anchor, ...], session: Session) -> FloatArray:
    found = np.array([cup.centre_mm for cup in cups])
    return _moved(
        points_mm, found, np.array([session.cups_mm[cup.placement, cup.base_point] for cup in cups])
    )


def _moved(points_mm: FloatArray, moving_mm: FloatArray, fixed_mm: FloatArray) -> FloatArray:
    rotation, translation = rigid_alignment(moving_mm, fixed_mm)
    return np.asarray(points_mm @ rotation.T + translation)


def _mean_off(points_mm: FloatArray, true_mm: FloatArray) -> float:
    return float(np.linalg.norm(points_mm - true_mm, axis=1).mean())


def _stated(model: Model, session: Session) -> Stated | None:
    """Judge what a model states; None where the truth identifies no model."""
    reference = identify(without_noise(session), model.effects).model
    if reference is None:
        return None
    values = {parameter.name: parameter.value for parameter in reference.parameters}
    scores = (
        (parameter.value - values.get(parameter.name, math.nan)) / parameter.standard_uncertainty
        for parameter in model.parameters
        if parameter.effect != _BASE and parameter.standard_uncertainty > 0.0
    )
    predicted, stated = predict(model, session.readings.stops, session.readings.nest)
    true = session.validation_mm
    tied = _tied(predicted, identified_anchors(model), session)
    return Stated(tuple(scores), _rms(tied - true), _rms(predicted - true), _rms(stated))


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
