"""The single-axis circle test: what each joint errs by, turned alone."""

import asyncio
from typing import TYPE_CHECKING

from markupsafe import Markup

from truepose.analysis.campaigns.measured import circles_by_session
from truepose.exchange.results.circles import circle_document
from truepose.web.context import Context
from truepose.web.results.kinds import Choice, Form, Origin, ResultKind
from truepose.web.results.traces import Shown, traced
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.front.page import Front


async def _content(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> Markup:
    from truepose.reports.circles.report import circle_content

    number = origin.record.id
    test = await circles_by_session(here.sessions, here.readings, number)
    robot = (await here.sessions.setup(number)).cell.robot.name
    shown = Shown(f"/api/v1/sessions/{number}/circles", circle_document(test, robot))
    ending = await traced(here, origin, shown, None, words)
    return await asyncio.to_thread(circle_content, test, ending, words)


async def _first_page(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> "Front":
    from truepose.reports.front.held_to_limit import Limit, circles_front

    number = origin.record.id
    test = await circles_by_session(here.sessions, here.readings, number)
    robot = (await here.sessions.setup(number)).cell.robot.name
    return circles_front(test, robot, Limit(choice.limit_mm, choice.rule), words)


def _form(here: Context) -> Form:
    return Form("plan_test.circles.meaning", (), {"role": "validation", "plan": {"method": "circles"}})


CIRCLES = ResultKind(
    "circles",
    "plan_test.circles",
    lambda origin: origin.method == "circles",
    _content,
    limited=True,
    form=_form,
    first_page=_first_page,
)
