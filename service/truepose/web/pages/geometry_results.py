"""Tests of geometry: each joint turned alone, and models against ballbar lengths to one ball."""

import asyncio
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from truepose.analysis.campaigns.records import circles_by_session
from truepose.exchange.results.circles_and_spheres import circle_document, sphere_document
from truepose.messages.catalogue import Catalogue
from truepose.web.context import Context
from truepose.web.pages.conditions import ResultDocument, audit_of, session_conditions
from truepose.web.pages.session_results import Choice, Entry, Form, Origin, ResultKind, models_of

if TYPE_CHECKING:
    from truepose.reports.report import Report
    from truepose.validation.sphere_test import SphereTest


async def _circles(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> "Report":
    from truepose.reports.circles import CircleReport
    from truepose.reports.limits import Limit

    number = origin.record.id
    test = await circles_by_session(here.sessions, here.readings, number)
    robot = (await here.sessions.setup(number)).cell.robot.name
    shown = ResultDocument(f"/api/v1/sessions/{number}/circles", circle_document(test, robot))
    return CircleReport(
        test,
        robot,
        Limit(choice.limit_mm, choice.rule),
        conditions=await session_conditions(here, origin, words),
        language=words.tag,
        audit=await audit_of(here, origin, shown, None),
    )


def _circles_form(here: Context) -> Form:
    return Form("plan_test.circles.meaning", (), {"role": "validation", "plan": {"method": "circles"}})


CIRCLES = ResultKind(
    "circles",
    "plan_test.circles",
    lambda origin: origin.method == "circles",
    _circles,
    limited=True,
    form=_circles_form,
)


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
    from truepose.validation.sphere_test import sphere_test

    view = await here.ballbar_sessions.view(session_id)
    numbers = dict.fromkeys([*model_ids, *([view.plan.model_id] if view.plan.model_id else [])])
    models = {_named(number): (await here.results.model(number)).model for number in numbers}
    campaign = await here.ballbar_sessions.campaign(session_id)
    test = await asyncio.to_thread(sphere_test, campaign, models)
    # Whoever skips what the bar does not reach leaves out the largest errors: the test has to say so (commit
    # eeac81a9).
    return replace(test, skipped=view.situation.progress.skipped_poses), campaign.robot.name


async def _sphere(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> "Report":
    from truepose.reports.limits import Limit
    from truepose.reports.spheres import SphereReport
    from truepose.validation.sphere_test import NOMINAL

    number, models = origin.record.id, await _models(here, origin, choice)
    test, robot = await sphere_of(here, number, models)
    asked = "&".join(f"model_id={model}" for model in models)
    shown = ResultDocument(
        f"/api/v1/sessions/{number}/sphere?{asked}".rstrip("?"), sphere_document(test, robot)
    )
    judged = await here.results.model(models[0]) if models else None
    return SphereReport(
        test,
        robot,
        Limit(choice.limit_mm, choice.rule),
        _named(models[0]) if models else NOMINAL,
        conditions=await session_conditions(here, origin, words),
        language=words.tag,
        audit=await audit_of(here, origin, shown, judged),
    )


def _named(model_id: int) -> str:
    return f"model {model_id}"


async def _models(here: Context, origin: Origin, choice: Choice) -> list[int]:
    """Return the model that was chosen, else the newest of this robot where there is one."""
    if choice.model_id is not None:
        return [choice.model_id]
    robot = (await here.sessions.setup(origin.record.id)).cell.robot.name
    return [model.id for model in await models_of(here, robot, 1)]


def _sphere_form(here: Context) -> Form:
    return Form(
        "plan_test.sphere.meaning",
        (
            Entry("plan.model_id", "plan_test.commands", "model or none"),
            Entry("plan.configurations", "plan_test.stops", value=24, least=6, most=250),
            *(Entry(f"placements.0.{name}", label, value=value) for name, label, value in _PLACEMENT),
        ),
        {"kind": "ballbar", "plan": {"method": _METHOD}, "placements": [{}]},
        "/api/v1/sessions",
    )


SPHERE = ResultKind(
    "sphere",
    "plan_test.sphere",
    lambda origin: origin.method == _METHOD,
    _sphere,
    judges=True,
    limited=True,
    form=_sphere_form,
)
