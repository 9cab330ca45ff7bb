"""The ballbar sphere test: models against lengths to one ball."""

import asyncio
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from markupsafe import Markup

from truepose.exchange.results.spheres import sphere_document
from truepose.web.context import Context
from truepose.web.results.kinds import Choice, Entry, Form, Origin, ResultKind
from truepose.web.results.models import models_of
from truepose.web.results.traces import Shown, traced
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.judgement.sphere.judged import SphereTest
    from truepose.reports.front.page import Front

_METHOD: Final = "sphere"
_PLACEMENT: Final = (
    ("x_mm", "plan_test.fixture_x", None),
    ("y_mm", "plan_test.fixture_y", None),
    ("z_mm", "plan_test.fixture_z", None),
    ("rx_deg", "plan_test.fixture_rx", 0.0),
    ("ry_deg", "plan_test.fixture_ry", 0.0),
    ("rz_deg", "plan_test.fixture_rz", 0.0),
)


async def sphere_of(here: Context, session_id: int, model_ids: Sequence[int]) -> "tuple[SphereTest, str]":
    """Return what a session says of models, of the one that commanded the arm too, and the robot's name.

    Raises NotFoundError, NotNowError, StorageError, NothingMeasuredError, ConfigurationError.
    """
    from truepose.judgement.sphere.judged import sphere_test

    view = await here.ballbar_sessions.view(session_id)
    numbers = dict.fromkeys([*model_ids, *([view.plan.model_id] if view.plan.model_id else [])])
    models = {_named(number): (await here.results.model(number)).model for number in numbers}
    campaign = await here.ballbar_sessions.campaign(session_id)
    test = await asyncio.to_thread(sphere_test, campaign, models)
    return replace(test, skipped=view.situation.progress.skipped_poses), campaign.robot.name


async def _content(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> Markup:
    from truepose.reports.spheres.report import sphere_content

    number, models = origin.record.id, await _models(here, origin, choice)
    test, robot = await sphere_of(here, number, models)
    asked = "&".join(f"model_id={model}" for model in models)
    shown = Shown(f"/api/v1/sessions/{number}/sphere?{asked}".rstrip("?"), sphere_document(test, robot))
    judged = await here.results.model(models[0]) if models else None
    ending = await traced(here, origin, shown, judged, words)
    return await asyncio.to_thread(sphere_content, test, ending, words)


async def _first_page(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> "Front":
    from truepose.judgement.sphere.judged import NOMINAL
    from truepose.reports.front.held_to_limit import Limit, sphere_front

    models = await _models(here, origin, choice)
    test, robot = await sphere_of(here, origin.record.id, models)
    judged = _named(models[0]) if models else NOMINAL
    return sphere_front(test, robot, judged, Limit(choice.limit_mm, choice.rule), words)


def _named(model_id: int) -> str:
    return f"model {model_id}"


async def _models(here: Context, origin: Origin, choice: Choice) -> list[int]:
    """Return the model that was chosen, else the newest of this robot where there is one."""
    if choice.model_id is not None:
        return [choice.model_id]
    robot = (await here.sessions.setup(origin.record.id)).cell.robot.name
    return [model.id for model in await models_of(here, robot, 1)]


def _form(here: Context) -> Form:
    return Form(
        "plan_test.sphere.meaning",
        (
            Entry("plan.model_id", "plan_test.commands", "model or none"),
            Entry("plan.configurations", "plan_test.stops", value=24, least=6, most=250),
            *(Entry(f"placements.0.{name}", label, value=value) for name, label, value in _PLACEMENT),
        ),
        {"plan": {"method": _METHOD}, "placements": [{}]},
        "/api/v1/ballbar-sessions",
    )


SPHERE = ResultKind(
    "sphere",
    "plan_test.sphere",
    lambda origin: origin.method == _METHOD,
    _content,
    judges=True,
    limited=True,
    form=_form,
    first_page=_first_page,
)
