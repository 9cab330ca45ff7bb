"""A diagnosis that asked for more configurations is run again once a session has measured them."""

from dataclasses import dataclass

from truepose.analysis.campaigns.records import CampaignService
from truepose.analysis.jobs import JobService
from truepose.domain.errors import TrueposeError, text_of
from truepose.messages.message import message
from truepose.storage.ledger.added_stops import AddedStopsRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.records import DiagnosisRecord
from truepose.storage.results.campaigns import CampaignRepository
from truepose.storage.results.diagnoses import DiagnosisRepository


@dataclass(frozen=True, slots=True)
class RepeatedDiagnosis:
    """Queues the diagnosis anew, on all readings that the session has then."""

    additions: AddedStopsRepository
    diagnoses: DiagnosisRepository
    campaigns: CampaignRepository
    sessions: SessionRepository
    campaign_desk: CampaignService
    job_desk: JobService

    async def after_session(self, session_id: int) -> None:
        """Queue what was wanted after this session; why it cannot be is noted with the session."""
        diagnosis_id = await self.additions.diagnosis_to_repeat(session_id)
        if diagnosis_id is None:
            return
        try:
            await self._repeat(session_id, await self.diagnoses.get(diagnosis_id))
        # The session has finished well; what cannot be diagnosed again is a note and no failure.
        except TrueposeError as error:
            why = message("session.not_diagnosed_again", diagnosis=diagnosis_id, why=text_of(error))
            await self.sessions.note(session_id, why)

    async def _repeat(self, session_id: int, earlier: DiagnosisRecord) -> None:
        """Start from what the earlier one started from, judged by the same validation session."""
        measured = await self.campaigns.get(earlier.campaign_id)
        # The same session judges both, so that their figures can be compared.
        validation_id = measured.session_ids[1] if len(measured.session_ids) > 1 else None
        campaign_id = await self.campaign_desk.from_sessions(measured.name, session_id, validation_id)
        found = earlier.diagnosis
        # Readings that a person set aside come back by nothing that was measured since.
        await self.job_desk.diagnose(campaign_id, found.start_effects, set_aside=found.set_aside)
