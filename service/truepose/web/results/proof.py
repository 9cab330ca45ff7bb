"""The proof of a correction: the same targets without and with it."""

import asyncio
from typing import TYPE_CHECKING

from markupsafe import Markup

from truepose.analysis.campaigns.measured import proof_by_session
from truepose.domain.sentences import Sentence, said
from truepose.exchange.results.proofs import proof_document
from truepose.sequencing.engine.identity.expected import same_number
from truepose.storage.records import ModelRecord
from truepose.web.context import Context
from truepose.web.results.kinds import Choice, Entry, Form, Origin, ResultKind
from truepose.web.results.models import made_on
from truepose.web.results.traces import Shown, traced
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.front.page import Front

_PROVES = "proves_model_id"


async def _content(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> Markup:
    from truepose.reports.proof.report import ProofInput, proof_content

    number, model = origin.record.id, await here.results.model(origin.asked[_PROVES])
    proof = await proof_by_session(here.sessions, here.readings, number, model.model)
    shown = Shown(f"/api/v1/sessions/{number}/proof?model_id={model.id}", proof_document(proof))
    ending = await traced(here, origin, shown, model, words)
    warnings = await _warnings(here, model, ending.conditions.robot_serial_number)
    report = ProofInput(proof, words.say("audit.model", number=model.id), ending, warnings)
    return await asyncio.to_thread(proof_content, report, words)


async def _first_page(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> "Front":
    from truepose.reports.front.kinds import proof_front

    model = await here.results.model(origin.asked[_PROVES])
    proof = await proof_by_session(here.sessions, here.readings, origin.record.id, model.model)
    return proof_front(proof, model.robot, words)


async def _warnings(here: Context, model: ModelRecord, serial: str) -> tuple[Sentence, ...]:
    """Return what speaks against the model beside the readings: it was made on another robot."""
    made_for = await made_on(here, model)
    if not made_for or not serial or same_number(made_for, serial):
        return ()
    return (said("proof.other_serial", made_for=made_for, here=serial),)


def _form(here: Context) -> Form:
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
    _content,
    form=_form,
    first_page=_first_page,
)
