"""What a session measured, out of the storage."""

import asyncio
from dataclasses import dataclass, replace

from truepose.analysis.campaigns.assembly import MeasuredSession, point_readings
from truepose.analysis.errors import NothingMeasuredError
from truepose.correction.proof.verdict import Proof, proof_of
from truepose.domain.measurement.campaign import PointReadings
from truepose.domain.results.identification import Model, NominalAndIdentified
from truepose.domain.results.validation import DecisionRule, Validation
from truepose.judgement.circle.judged import CircleTest, circle_test
from truepose.judgement.iso9283.judged import PoseTest, pose_test
from truepose.judgement.validation import validate
from truepose.storage.measurement.sessions import SessionRepository
from truepose.storage.measurement.tracker_readings import ReadingRepository


@dataclass(frozen=True, slots=True)
class AskedAccuracy:
    """By what the points of a session are judged."""

    model: Model
    limit_mm: float | None = None
    rule: DecisionRule = "guard band"
    of_poses: bool = False  # they are visits of a test of ISO 9283
    elsewhere: NominalAndIdentified | None = None  # held-out errors in the work space


@dataclass(frozen=True, slots=True)
class Accuracy:
    """What the points of a session say of a model."""

    points: PointReadings
    validation: Validation
    test: PoseTest | None


async def measured_session(
    sessions: SessionRepository, readings: ReadingRepository, session_id: int
) -> MeasuredSession:
    """Return a session with its readings; raises NotFoundError."""
    return MeasuredSession(
        id=session_id,
        setup=await sessions.setup(session_id),
        points=tuple(await readings.points(session_id)),
        fixed_nests=tuple(await readings.fixed_nests(session_id)),
        registration=await sessions.registration(session_id),
    )


async def proof_by_session(
    sessions: SessionRepository, readings: ReadingRepository, session_id: int, model: Model
) -> Proof:
    """Judge a model by a session that was planned to prove it.

    Raises NotFoundError, StorageError, NothingMeasuredError, and ConfigurationError where the session was
    not planned with this model.
    """
    points = await _points(sessions, readings, session_id)
    return await asyncio.to_thread(proof_of, model, points, model.repeatability_mm)


async def circles_by_session(
    sessions: SessionRepository, readings: ReadingRepository, session_id: int
) -> CircleTest:
    """Say what each joint errs by, by a session that turned one at a time.

    Raises NotFoundError, StorageError, NothingMeasuredError, and ConfigurationError where none was turned
    alone.
    """
    return await asyncio.to_thread(circle_test, await _points(sessions, readings, session_id))


async def accuracy_by_session(
    sessions: SessionRepository, readings: ReadingRepository, session_id: int, asked: AskedAccuracy
) -> Accuracy:
    """Judge a model by the points of a session.

    Raises NotFoundError, StorageError, NothingMeasuredError, and ConfigurationError where the readings do not
    fit the model, or are not the test that is asked for.
    """
    return await asyncio.to_thread(_judged, await _points(sessions, readings, session_id), asked)


def _judged(points: PointReadings, asked: AskedAccuracy) -> Accuracy:
    validation = validate(asked.model, points, limit_mm=asked.limit_mm, rule=asked.rule)
    test = pose_test(asked.model, points) if asked.of_poses else None
    if test is not None and test.work_space is None:
        test = replace(test, work_space=asked.elsewhere)
    return Accuracy(points, validation, test)


async def _points(sessions: SessionRepository, readings: ReadingRepository, session_id: int) -> PointReadings:
    await sessions.require_intact(session_id)
    measured = await measured_session(sessions, readings, session_id)
    if not measured.points:
        raise NothingMeasuredError(f"Session {session_id} has no reading of a tool nest yet.")
    return point_readings(measured.points)
