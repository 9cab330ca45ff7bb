"""Campaigns into the storage: from an uploaded zip, or from sessions."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from datetime import date
from typing import Any, Final, TypeAlias

from truepose.analysis.campaigns.assembly import assemble_campaign, judged_by
from truepose.analysis.campaigns.measured import measured_session
from truepose.analysis.campaigns.summary import summary_of
from truepose.analysis.errors import RoleError
from truepose.analysis.workers.tasks import stored_campaign
from truepose.analysis.workers.uploads import Uploads
from truepose.domain.measurement.campaign import Campaign
from truepose.domain.measurement.session import SessionRole
from truepose.exchange.campaigns.zip_file import write_campaign_zip
from truepose.storage.calibration.campaigns import CampaignRepository, NewCampaign
from truepose.storage.columns import pack
from truepose.storage.measurement.sessions import SessionRepository
from truepose.storage.measurement.tracker_readings import ReadingRepository
from truepose.storage.records import CampaignSummary, RequestKey

OfBallbar: TypeAlias = Callable[[int], Awaitable[Campaign]]  # of a ballbar session, by its number
# Of a session of closed loops, by its number; held out: another of its kind.
OfContacts: TypeAlias = Callable[[int, int | None], Awaitable[Campaign]]


@dataclass(frozen=True, slots=True)
class Stated:
    """What is said of an upload beside its archive; what is None stays as the archive says."""

    measured_on: date | None = None
    robot_serial_number: str | None = None
    instrument_serial_number: str | None = None

    def in_summary(self, summary: CampaignSummary) -> CampaignSummary:
        """Return a summary with what was said."""
        said: dict[str, Any] = self.said
        return replace(summary, **said)

    def before(self, other: "Stated") -> "Stated":
        """Return what is said here, and else what is said there."""
        return Stated(
            self.measured_on or other.measured_on,
            self.robot_serial_number or other.robot_serial_number,
            self.instrument_serial_number or other.instrument_serial_number,
        )

    @property
    def said(self) -> dict[str, str]:
        """What was said, as a summary has it."""
        day = None if self.measured_on is None else self.measured_on.isoformat()
        named = {
            "measured_on": day,
            "robot_serial_number": self.robot_serial_number,
            "instrument_serial_number": self.instrument_serial_number,
        }
        return {name: value for name, value in named.items() if value}


NOTHING: Final = Stated()


class CampaignDesk:
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
        self, archive: bytes, name: str, stated: Stated = NOTHING, key: RequestKey | None = None
    ) -> int:
        """Store an uploaded zip as it is and return its number; call it within a turn of `uploads`.

        Cancelling it ends the reading, and nothing is stored. Raises as `Uploads.read`, KeyReusedError.
        """
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
        role = await self._check_roles(calibration_id, validation_id)
        await self._sessions.require_intact(calibration_id)
        if validation_id is not None:
            await self._sessions.require_intact(validation_id)
        calibration = await measured_session(self._sessions, self._readings, calibration_id)
        validation = (
            None
            if validation_id is None
            else await measured_session(self._sessions, self._readings, validation_id)
        )
        if role == "contacts":
            campaign = await self._contacts(calibration_id, validation_id)
        elif role == "ballbar":
            campaign = await self._of_ballbar(calibration_id)
            campaign = campaign if validation is None else judged_by(campaign, calibration, validation)
        else:
            campaign = await asyncio.to_thread(assemble_campaign, calibration, validation)
        packed = await asyncio.to_thread(pack, campaign)
        numbers = (calibration_id,) if validation_id is None else (calibration_id, validation_id)
        stored = NewCampaign(name, campaign.robot.name, summary_of(campaign), packed, session_ids=numbers)
        return await self._campaigns.add(stored, key)

    async def _contacts(self, calibration_id: int, validation_id: int | None) -> Campaign:
        """Return the campaign of a session of closed loops, judged by another, or by one with a tracker."""
        if validation_id is None or (await self._sessions.get(validation_id)).role == "contacts":
            return await self._of_contacts(calibration_id, validation_id)
        campaign = await self._of_contacts(calibration_id, None)
        measured = [
            await measured_session(self._sessions, self._readings, number)
            for number in (calibration_id, validation_id)
        ]
        return judged_by(campaign, *measured)

    async def archive(self, campaign_id: int) -> bytes:
        """Return the zip of a campaign folder, as it came or else written now; raises NotFoundError."""
        uploaded = await self._campaigns.archive(campaign_id)
        return uploaded or await asyncio.to_thread(_zipped, await self._campaigns.content(campaign_id))

    async def _check_roles(self, calibration_id: int, validation_id: int | None) -> SessionRole:
        # A calibration session may judge another one's model; what was kept for validation never identifies.
        role = (await self._sessions.get(calibration_id)).role
        if role == "validation":
            raise RoleError(
                f"Session {calibration_id} is for validation, its readings never identify; "
                "make the campaign of a calibration session and name this one as its validation session."
            )
        if calibration_id == validation_id:
            raise RoleError(
                f"Session {calibration_id} cannot judge the model that it identifies; "
                "name another session, or none."
            )
        judging = None if validation_id is None else (await self._sessions.get(validation_id)).role
        if judging == "contacts" and role != "contacts":
            raise RoleError(
                f"Session {validation_id} is one of closed loops, whose targets no other session knows; "
                "name a session with the tracker as its validation session."
            )
        if judging == "ballbar":
            raise RoleError(
                f"Session {validation_id} is one with the ballbar, whose cups no other session knows; "
                "name a session with the tracker as its validation session."
            )
        return role


def _zipped(content: bytes) -> bytes:
    return write_campaign_zip(stored_campaign(content))
