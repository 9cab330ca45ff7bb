"""How accurate a robot is: by a validation session, by ISO 9283, without and with a correction."""

from typing import TYPE_CHECKING, Final
from urllib.parse import urlencode

from truepose.analysis.campaigns.records import (
    Accuracy,
    AskedAccuracy,
    accuracy_by_session,
    proof_by_session,
)
from truepose.domain.identification import Identification, NominalAndIdentified
from truepose.exchange.results.corrections import proof_document
from truepose.exchange.results.validation import accuracy_document
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, message
from truepose.sessions.engine.identity_check import same_number
from truepose.storage.records import ModelRecord
from truepose.web.api.sessions.schemas import MOST_STOPS
from truepose.web.context import Context
from truepose.web.pages.conditions import ResultDocument, audit_of, session_conditions
from truepose.web.pages.session_results import (
    Choice,
    Entry,
    Form,
    Origin,
    ResultKind,
    model_for,
    robot_of_model,
)

if TYPE_CHECKING:
    from truepose.reports.report import Report


_TESTS: Final = (
    ("poses", "plan_test.iso9283.poses"),
    ("directions", "plan_test.iso9283.directions"),
    ("drift", "plan_test.iso9283.drift"),
)
_PLANES: Final = (
    ("y+", "plan_test.plane.y_up"),
    ("y-", "plan_test.plane.y_down"),
    ("x+", "plan_test.plane.x_up"),
    ("x-", "plan_test.plane.x_down"),
)


async def accuracy_of(here: Context, origin: Origin, choice: Choice) -> tuple[ModelRecord, Accuracy]:
    """Return the model that judges, and what the session says of it."""
    model = await model_for(here, origin, choice)
    of_poses = is_pose_test(origin)
    elsewhere = await _held_out(here, model) if of_poses else None
    asked = AskedAccuracy(model.model, choice.limit_mm, choice.rule, of_poses, elsewhere)
    return model, await accuracy_by_session(here.sessions, here.readings, origin.record.id, asked)


def is_pose_test(origin: Origin) -> bool:
    """Whether a session visits poses of ISO 9283."""
    return origin.method.startswith("iso9283")


async def _held_out(here: Context, model: ModelRecord) -> NominalAndIdentified | None:
    """Return the errors that a model showed where it was judged; None of a diagnosis, or of lengths."""
    if model.identification_id is None:
        return None
    found: Identification = (await here.results.identification(model.identification_id)).identification
    return (found.validation or found.cross_validation) if found.quantity == "position" else None


async def _accuracy(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> "Report":
    from truepose.reports.validation import ValidationReport
    from truepose.validation.cautions import validation_cautions

    model, found = await accuracy_of(here, origin, choice)
    shown = ResultDocument(_address(origin, model, choice), accuracy_document(found.validation, found.test))
    return ValidationReport(
        found.validation,
        model.model,
        found.points,
        tuple(validation_cautions(model.model, found.points)),
        found.test,
        conditions=await session_conditions(here, origin, words),
        language=words.tag,
        audit=await audit_of(here, origin, shown, model),
    )


def _address(origin: Origin, model: ModelRecord, choice: Choice) -> str:
    limit = {} if choice.limit_mm is None else {"limit_mm": repr(choice.limit_mm), "rule": choice.rule}
    return f"/api/v1/sessions/{origin.record.id}/accuracy?{urlencode({'model_id': model.id} | limit)}"


def _pose_test_form(here: Context) -> Form:
    return Form(
        "plan_test.iso9283.meaning",
        (
            Entry("plan.test", "plan_test.iso9283.test", "choice", choices=_TESTS),
            Entry("plan.edge_mm", "plan_test.edge", least=1, most=10_000),
            Entry("plan.centre_mm", "plan_test.centre_x", least=-100_000, most=100_000),
            Entry("plan.centre_mm", "plan_test.centre_y", least=-100_000, most=100_000),
            Entry("plan.centre_mm", "plan_test.centre_z", least=-100_000, most=100_000),
            Entry("plan.plane", "plan_test.plane", "choice", choices=_PLANES),
            Entry("plan.nest", "plan_test.nest", least=1, most=max(len(here.cell.nests), 1)),
            Entry("plan.cycles", "plan_test.cycles", value=30, least=1, most=MOST_STOPS // 9),
            Entry("plan.hours", "plan_test.hours", value=8, least=1, most=8),
        ),
        {"role": "validation", "plan": {"method": "iso9283"}},
    )


POSE_TEST = ResultKind(
    "iso9283",
    "plan_test.iso9283",
    is_pose_test,
    _accuracy,
    judges=True,
    limited=True,
    form=_pose_test_form,
)
ACCURACY = ResultKind(
    "accuracy",
    "plan_test.accuracy",
    lambda origin: origin.record.role == "validation",
    _accuracy,
    judges=True,
    limited=True,
)


_PROVES = "proves_model_id"


async def _proof(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> "Report":
    from truepose.reports.proof import ProofReport

    number, model = origin.record.id, await here.results.model(origin.asked[_PROVES])
    proof = await proof_by_session(here.sessions, here.readings, number, model.model)
    shown = ResultDocument(f"/api/v1/sessions/{number}/proof?model_id={model.id}", proof_document(proof))
    stated = await session_conditions(here, origin, words)
    return ProofReport(
        proof,
        model.robot,
        words.say("audit.model", number=model.id),
        await _warnings(here, model, stated.robot_serial_number),
        conditions=stated,
        language=words.tag,
        audit=await audit_of(here, origin, shown, model),
    )


async def _warnings(here: Context, model: ModelRecord, serial: str) -> tuple[Message, ...]:
    """Return what speaks against the model beside the readings: it was made on another robot."""
    made_for = await robot_of_model(here, model)
    if not made_for or not serial or same_number(made_for, serial):
        return ()
    return (message("proof.other_serial", made_for=made_for, here=serial),)


def _proof_form(here: Context) -> Form:
    return Form(
        "plan_test.prove.meaning",
        (
            Entry("plan.model_id", "plan_test.model", "model"),
            Entry("plan.targets", "plan_test.targets", value=30, least=2, most=2500),
        ),
        {"role": "validation", "plan": {"method": "prove"}},
    )


PROOF = ResultKind(
    "prove",
    "plan_test.prove",
    lambda origin: _PROVES in origin.asked,
    _proof,
    form=_proof_form,
)
