"""The single-axis circle test: what each joint errs by, turned alone."""

import asyncio

from markupsafe import Markup

from truepose.analysis.measured import circles_by_session
from truepose.exchange.results.circles import circle_document
from truepose.web.context import Context
from truepose.web.results.kinds import Choice, Form, Origin, ResultKind
from truepose.web.results.traces import Shown, traced
from truepose.words.catalogue import Catalogue


async def _content(here: Context, origin: Origin, choice: Choice, words: Catalogue) -> Markup:
    from truepose.reports.circles.report import circle_content

    number = origin.record.id
    test = await circles_by_session(here.sessions, here.readings, number)
    robot = (await here.sessions.setup(number)).cell.robot.name
    shown = Shown(f"/api/v1/sessions/{number}/circles", circle_document(test, robot))
    ending = await traced(here, origin, shown, None, words)
    return await asyncio.to_thread(circle_content, test, ending, words)


def _form(here: Context) -> Form:
    return Form("plan_test.circles.meaning", (), {"role": "validation", "plan": {"method": "circles"}})


CIRCLES = ResultKind(
    "circles", "plan_test.circles", lambda origin: origin.method == "circles", _content, form=_form
)
