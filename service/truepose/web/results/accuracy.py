"""How accurate a robot is, by a validation session or by a test of ISO 9283."""

import asyncio
from typing import TYPE_CHECKING, Final
from urllib.parse import urlencode

from markupsafe import Markup

from truepose.analysis.campaigns.measured import Accuracy, AskedAccuracy, accuracy_by_session
from truepose.domain.results.identification import Identification, NominalAndIdentified
from truepose.exchange.results.iso9283 import accuracy_document
from truepose.storage.records import ModelRecord
from truepose.web.context import Context
from truepose.web.results.kinds import Choice, Entry, Form, Origin, ResultKind
from truepose.web.results.models import model_for
from truepose.web.results.traces import Shown, traced
from truepose.web.schemas.measurement.sessions import MOST_STOPS
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.front.page import Front

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


async def _content(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> Markup:
    from truepose.judgement.cautions import validation_cautions
    from truepose.reports.validation.report import ValidationInput, validation_content

    model, found = await accuracy_of(here, origin, choice)
    shown = Shown(_address(origin, model, choice), accuracy_document(found.validation, found.test))
    ending = await traced(here, origin, shown, model, words)
    report = ValidationInput(
        found.validation,
        model.model,
        found.points,
        tuple(validation_cautions(model.model, found.points)),
        found.test,
        ending.conditions,
        words.tag,
        ending.audit,
    )
    return await asyncio.to_thread(validation_content, report)


async def _first_page(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> "Front":
    from truepose.reports.front.kinds import validation_front

    model, found = await accuracy_of(here, origin, choice)
    robot = model.model.robot.name
    title = words.say("pose_test.title", robot=robot) if found.test is not None else ""
    return validation_front(found.validation, robot, words, title)


def _address(origin: Origin, model: ModelRecord, choice: Choice) -> str:
    limit = {} if choice.limit_mm is None else {"limit_mm": repr(choice.limit_mm), "rule": choice.rule}
    return f"/api/v1/sessions/{origin.record.id}/accuracy?{urlencode({'model_id': model.id} | limit)}"


def _form(here: Context) -> Form:
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
    _content,
    judges=True,
    limited=True,
    form=_form,
    first_page=_first_page,
)
ACCURACY = ResultKind(
    "accuracy",
    "plan_test.accuracy",
    lambda origin: origin.record.role == "validation",
    _content,
    judges=True,
    limited=True,
    first_page=_first_page,
)
