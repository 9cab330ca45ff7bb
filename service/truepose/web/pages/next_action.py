"""The one next step, from where things stand: measure, identify, diagnose, validate, correct, prove, report.

It follows from the records alone. No state of a workflow is kept that could contradict them (decision 0058).
"""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from truepose.domain.session import SessionState
from truepose.messages.message import Message, message
from truepose.sessions.engine.states import has_ended
from truepose.storage.results.items import FAILED, HELD_OUT, PROOF, TEST, UNDECIDED, WORSE, WorkItem, WorkKind
from truepose.storage.results.lineage import Lineage

_TESTING: Final = ("validation", TEST)  # roles of sessions whose readings judge
# What a person set aside does not come back by the step that follows.
_KEPT: Final[Mapping[str, Any]] = {"keep_set_aside": True}


@dataclass(frozen=True, slots=True)
class Ask:
    """One request to the API; `takes` names what it is told: the number made before the first so named."""

    path: str
    body: Mapping[str, Any] = field(default_factory=dict)
    takes: str = ""


@dataclass(frozen=True, slots=True)
class NextAction:
    """What to do next: a page to go to, or requests whose last one makes something that has a page."""

    why: Message
    action: str  # key of the catalogue
    href: str = ""
    asks: tuple[Ask, ...] = ()
    leads: str = ""  # the page of what was made, before its number; empty: this page again
    is_limited: bool = False  # whoever takes it may state a limit
    beside: "NextAction | None" = None  # what may be done without it

    @property
    def asked(self) -> list[dict[str, Any]]:
        """Its requests, as a page hands them to its script."""
        return [dataclasses.asdict(ask) for ask in self.asks]


@dataclass(frozen=True, slots=True)
class CellProgress:
    """How far a cell has come."""

    devices: tuple[str, ...] = ()
    connected: int = 0
    session: WorkItem | None = None  # the newest
    lineage: Lineage | None = None  # of the session
    job_id: int | None = None  # under way


def next_action(progress: CellProgress) -> NextAction:
    """Return what to do next in a cell."""
    session = progress.session
    if session is not None and _moves(session):
        return _go_to(session)
    if progress.job_id is not None:
        return NextAction(message("step.job.why"), "step.job", f"/jobs/{progress.job_id}")
    waits = session is not None and session.state == SessionState.PLANNED
    made = None if session is None or waits else action_after(progress.lineage or Lineage((session,)))
    if made is not None:
        return made
    if progress.devices and not progress.connected:
        asks = tuple(Ask(f"/api/v1/devices/{name}/connect") for name in progress.devices)
        return NextAction(message("step.connect.why"), "step.connect", asks=asks)
    if session is not None and waits:
        return _start(session)
    return NextAction(message("step.plan.why"), "step.plan", "/plan")


def action_after(lineage: Lineage) -> NextAction | None:
    """Return what to do with what was measured, identified or made; None where all is done."""
    proof = lineage.newest(WorkKind.SESSION, PROOF)
    if proof is not None:
        return _of_proof(proof)
    # From the end of the way: the last thing that was made says what follows.
    for find in (_of_correction, _of_model, _of_campaign, _of_session):
        step = find(lineage)
        if step is not None:
            return step
    return None


def identify_and_diagnose(session_id: int, name: str) -> NextAction:
    """Return what makes an identification and a diagnosis of what a session has measured so far."""
    asks = (
        Ask(f"/api/v1/sessions/{session_id}/campaign", {"name": name}),
        Ask("/api/v1/identifications", _KEPT, takes="campaign_id"),
        Ask("/api/v1/diagnoses", _KEPT, takes="campaign_id"),
    )
    return NextAction(message("step.identify.why"), "session.diagnose", asks=asks, leads="/diagnoses")


def _moves(session: WorkItem) -> bool:
    state = SessionState(session.state)
    return not has_ended(state) and state is not SessionState.PLANNED


def _go_to(session: WorkItem) -> NextAction:
    return NextAction(
        message("step.session.why", name=session.name), "step.session", f"/sessions/{session.id}"
    )


def _start(session: WorkItem) -> NextAction:
    return NextAction(message("step.start.why", name=session.name), "step.start", f"/sessions/{session.id}")


def _of_proof(proof: WorkItem) -> NextAction | None:
    if proof.state == SessionState.PLANNED:
        return _start(proof)
    if _moves(proof):
        return _go_to(proof)
    if proof.state == SessionState.FINISHED:
        return NextAction(message("step.report.why"), "step.report", f"/reports/session/{proof.id}")
    return None


def _of_correction(lineage: Lineage) -> NextAction | None:
    correction, model = lineage.newest(WorkKind.CORRECTION), lineage.newest(WorkKind.MODEL)
    if correction is None or model is None:
        return None
    address = f"/sessions/new?model_id={model.id}#prove"
    return NextAction(message("step.prove.why", name=correction.name), "step.prove", address)


def _of_model(lineage: Lineage) -> NextAction | None:
    """Return the step after a model: a diagnosis says what it leaves, a validation whether it may be used."""
    diagnosis, model = lineage.newest(WorkKind.DIAGNOSIS), lineage.newest(WorkKind.MODEL)
    if model is None:
        return None
    campaign = lineage.newest(WorkKind.CAMPAIGN)
    if diagnosis is None and campaign is not None:
        asks = (Ask("/api/v1/diagnoses", {"campaign_id": campaign.id, **_KEPT}),)
        return NextAction(message("step.diagnose.why"), "step.diagnose", asks=asks, leads="/diagnoses")
    correct = NextAction(message("step.correct.why"), "step.correct", f"/corrections?model_id={model.id}")
    validation = lineage.newest(WorkKind.VALIDATION)
    if validation is None or validation.recorded_at < model.recorded_at:
        return _validate(model, campaign, correct)
    if validation.state in {FAILED, WORSE}:
        return NextAction(message("step.not_passed.why"), "step.plan", "/plan", beside=correct)
    if validation.state == UNDECIDED:
        return replace(_validate(model, campaign, correct), why=message("step.undecided.why"))
    return correct


def _validate(model: WorkItem, campaign: WorkItem | None, beside: NextAction) -> NextAction:
    """Return what judges a model: readings of its campaign that it never saw, else a test to be measured."""
    if campaign is None or campaign.role != HELD_OUT:
        why = message("step.validate.measure.why")
        return NextAction(why, "step.validate", "/sessions/new#iso9283", beside=beside)
    asks = (Ask("/api/v1/validations", {"model_id": model.id, "campaign_id": campaign.id}),)
    why = message("step.validate.why")
    return NextAction(why, "step.validate", asks=asks, leads="/validations", is_limited=True, beside=beside)


def _of_campaign(lineage: Lineage) -> NextAction | None:
    campaign = lineage.newest(WorkKind.CAMPAIGN)
    if campaign is None:
        return None
    if lineage.newest(WorkKind.DIAGNOSIS) or lineage.newest(WorkKind.IDENTIFICATION):
        return NextAction(message("step.again.why"), "step.plan", "/plan")  # nothing could be fitted
    asks = (Ask("/api/v1/identifications", {"campaign_id": campaign.id}),)
    return NextAction(message("step.identify.why"), "step.identify", asks=asks, leads="/identifications")


def _of_session(lineage: Lineage) -> NextAction | None:
    session = lineage.newest(WorkKind.SESSION)
    if session is None or session.state != SessionState.FINISHED:
        return None
    if session.role in _TESTING:
        return NextAction(message("step.result.why"), "step.result", f"/sessions/{session.id}/result")
    asks = (
        Ask(f"/api/v1/sessions/{session.id}/campaign", {"name": session.name}),
        Ask("/api/v1/identifications", takes="campaign_id"),
    )
    return NextAction(message("step.identify.why"), "step.identify", asks=asks, leads="/identifications")
