"""Reports of what sessions came to: proofs, tests, circles, spheres."""

from typing import TYPE_CHECKING, Any

from truepose.storage.errors import ConflictError
from truepose.web.context import Context
from truepose.web.reports.conditions import conditions_of_sessions
from truepose.web.reports.kinds import LISTED, Drawable, ReportKind, ReportRow
from truepose.web.results.kinds import Choice, Origin, ResultKind
from truepose.web.results.origins import origin_of, origins_of
from truepose.web.results.registry import kind_of
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.front.framed import Framed
    from truepose.reports.front.page import Front
    from truepose.reports.traceability.conditions import ReportConditions


def draw_framed(report: Any) -> str:
    """Return the report as a page."""
    from truepose.reports.front.framed import framed_page

    return framed_page(report)


async def _rows(here: Context, month: str) -> list[ReportRow]:
    records = await here.sessions.newest_of(LISTED, month)
    return [await _row(here, origin) for origin in await origins_of(here, records) if _has_result(origin)]


def _has_result(origin: Origin) -> bool:
    return origin.record.measured > 0 and kind_of(origin) is not None


async def _row(here: Context, origin: Origin) -> ReportRow:
    record, kind, cell = origin.record, kind_of(origin), (await here.sessions.setup(origin.record.id)).cell
    return ReportRow(
        "session",
        record.id,
        "reports.session" if kind is None else kind.title,
        record.recorded_at,
        cell.robot.name,
        record.name,
        record.simulated,
        cell.robot_serial_number,
    )


async def _drawable(here: Context, number: int, choice: Choice, words: Catalogue) -> Drawable:
    origin = await origin_of(here, number)
    kind = kind_of(origin)
    if kind is None:
        raise ConflictError("The readings of this session are for an identification; its report is that one.")
    content = await kind.content(here, origin, choice, words)
    front = await _front(here, origin, kind, choice, words)

    def framed(whole: "ReportConditions") -> "Framed":
        from truepose.reports.front.framed import Framed

        return Framed(front, content, whole, words.tag)

    return Drawable(
        (number, choice, await here.sessions.chain_head(number)),
        lambda spoken: conditions_of_sessions(here, [number], spoken),
        draw_framed,
        framed,
    )


async def _front(
    here: Context, origin: Origin, kind: ResultKind, choice: Choice, words: Catalogue
) -> "Front":
    from truepose.reports.front.page import Front

    if kind.first_page is not None:
        return await kind.first_page(here, origin, choice, words)
    robot = (await here.sessions.setup(origin.record.id)).cell.robot.name
    return Front(f"{words.say(kind.title)}: {origin.record.name}", "", "", words.say("front.session"), robot)


SESSION = ReportKind("session", "reports.session", _rows, _drawable)
