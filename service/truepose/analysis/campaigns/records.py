"""What sessions measured, out of the storage, and campaigns into it: from uploads, or from sessions."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import asdict, dataclass, replace
from datetime import date
from typing import Any, Final, TypeAlias

from truepose.analysis.campaigns.tracker import (
    MeasuredSession,
    assemble_campaign,
    point_readings,
    summary_of,
    with_validation_points,
)
from truepose.analysis.errors import NothingMeasuredError, RoleError
from truepose.analysis.job_queue.tasks import stored_campaign
from truepose.analysis.job_queue.uploads import Uploads
from truepose.correction.proof import Proof, proof_of
from truepose.domain.campaign import Campaign, PointReadings
from truepose.domain.identification import Model, NominalAndIdentified
from truepose.domain.session import SessionRole
from truepose.domain.validation import DecisionRule, Validation
from truepose.exchange.campaigns.zip_file import write_campaign_zip
from truepose.messages.message import message
from truepose.storage.documents import pack
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.ledger.tracker_readings import ReadingRepository
from truepose.storage.records import CampaignSummary, RequestKey
from truepose.storage.results.campaigns import CampaignRepository, NewCampaign
from truepose.validation.circle_test import CircleTest, circle_test
from truepose.validation.iso9283.pose_test import PoseTest, pose_test
from truepose.validation.validate import validate


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
        raise NothingMeasuredError(message("refused.no_nest_reading", session=session_id))
    return point_readings(measured.points)


OfBallbar: TypeAlias = Callable[[int], Awaitable[Campaign]]  # of a ballbar session, by its number
# Of a session of closed loops, by its number; held out: another of its kind.
OfContacts: TypeAlias = Callable[[int, int | None], Awaitable[Campaign]]


@dataclass(frozen=True, slots=True)
class UploadDetails:
    """What is said of an upload beside its archive; what is None stays as the archive says."""

    measured_on: date | None = None
    robot_serial_number: str | None = None
    instrument_serial_number: str | None = None

    def in_summary(self, summary: CampaignSummary) -> CampaignSummary:
        """Return a summary with what was said."""
        said: dict[str, Any] = self.said
        return replace(summary, **said)

    def before(self, other: "UploadDetails") -> "UploadDetails":
        """Return what is said here, and else what is said there."""
        return UploadDetails(
            self.measured_on or other.measured_on,
            self.robot_serial_number or other.robot_serial_number,
            self.instrument_serial_number or other.instrument_serial_number,
        )

    @property
    def said(self) -> dict[str, str]:
        """What was said, as a summary has it."""
        day = None if self.measured_on is None else self.measured_on.isoformat()
        named = asdict(self) | {"measured_on": day}
        return {name: value for name, value in named.items() if value}


NOTHING: Final = UploadDetails()


class CampaignService:
    """Checks a campaign before it is stored; what is stored can be read."""

    def __init__(
        self,
        campaigns: CampaignRepository,
        sessions: SessionRepository,
        readings: ReadingRepository,
        of_ballbar: OfBallbar,
        of_contacts: OfContacts,
        uploads: Uploads,
    ) -> None:
        self.uploads = uploads
        self._campaigns = campaigns
        self._sessions = sessions
        self._readings = readings
        self._of_ballbar = of_ballbar
        self._of_contacts = of_contacts

    async def upload(
        self, archive: bytes, name: str, stated: UploadDetails = NOTHING, key: RequestKey | None = None
    ) -> int:
        """Store an uploaded zip as it is and return its number; call it within a turn of `uploads`.

        Cancelling it ends the reading, and nothing is stored. Raises as `Uploads.read`, KeyReusedError.
        """
        # Before the archive is read: a client that sends it again after a broken connection costs no worker.
        made = None if key is None else await self._campaigns.answered(key)
        if made is not None:
            return made
        found = await self.uploads.read(archive, name)
        summary = stated.in_summary(found.summary)
        stored = NewCampaign(name, found.robot, summary, found.campaign, archive)
        return await self._campaigns.add(stored, key)

    async def from_sessions(
        self, name: str, calibration_id: int, validation_id: int | None, key: RequestKey | None = None
    ) -> int:
        """Store the campaign of one or two sessions; raises as `assemble_campaign`, RoleError, StorageError.

        The first one identifies; the second one judges, with a tracker, or in closed loops as the first.
        """
        roles = await self._check_roles(calibration_id, validation_id)
        numbers = (calibration_id,) if validation_id is None else (calibration_id, validation_id)
        # A record that is not as it was written must not come back as a campaign that looks sound.
        for number in numbers:
            await self._sessions.require_intact(number)
        campaign = await self._campaign_of(numbers, roles)
        packed = await asyncio.to_thread(pack, campaign)
        stored = NewCampaign(name, campaign.robot.name, summary_of(campaign), packed, session_ids=numbers)
        return await self._campaigns.add(stored, key)

    async def _campaign_of(self, numbers: tuple[int, ...], roles: tuple[SessionRole, ...]) -> Campaign:
        """Return the campaign of a session, judged by another one where there are two."""
        if roles == ("contacts", "contacts"):
            return await self._of_contacts(*numbers)
        measured = [await measured_session(self._sessions, self._readings, number) for number in numbers]
        if roles[0] == "ballbar":
            campaign = await self._of_ballbar(numbers[0])
        elif roles[0] == "contacts":
            campaign = await self._of_contacts(numbers[0], None)
        else:
            # Off the loop: thousands of readings become arrays, and another session may be under way.
            return await asyncio.to_thread(assemble_campaign, *measured)
        return campaign if len(measured) == 1 else with_validation_points(campaign, *measured)

    async def archive(self, campaign_id: int) -> bytes:
        """Return the zip of a campaign folder, as it came or else written now; raises NotFoundError."""
        uploaded = await self._campaigns.archive(campaign_id)
        return uploaded or await asyncio.to_thread(_zipped, await self._campaigns.content(campaign_id))

    async def _check_roles(self, calibration_id: int, validation_id: int | None) -> tuple[SessionRole, ...]:
        """Return the roles of one or two sessions; raises RoleError where they make no campaign."""
        # A calibration session may judge another one's model; what was kept for validation never identifies.
        role = (await self._sessions.get(calibration_id)).role
        if role == "validation":
            raise RoleError(message("refused.validation_never_identifies", session=calibration_id))
        if calibration_id == validation_id:
            raise RoleError(message("refused.judges_itself", session=calibration_id))
        if validation_id is None:
            return (role,)
        judging = (await self._sessions.get(validation_id)).role
        if judging == "contacts" and role != "contacts":
            raise RoleError(message("refused.contacts_validate_contacts", session=validation_id))
        # No other session knows where the seats of that ballbar were, from which its lengths count.
        if judging == "ballbar":
            raise RoleError(message("refused.ballbar_never_validates", session=validation_id))
        return role, judging


def _zipped(content: bytes) -> bytes:
    return write_campaign_zip(stored_campaign(content))
