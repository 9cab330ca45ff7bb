"""Parts of pages that take seconds to draw: drawn once, and the rest of a page is there at once."""

import asyncio
from typing import Annotated, Final

from fastapi import Query
from fastapi.responses import Response
from markupsafe import Markup

from truepose.analysis.kept import Draw
from truepose.storage.files.drawn import drawn_of
from truepose.web.visiting.files import sent
from truepose.web.visiting.visits import Visit

_AT_ONCE_S: Final = 0.3  # that a page waits for what is quick to draw
Whole = Annotated[bool, Query(description="Answer once everything of the page is drawn.")]


async def drawn_part(
    visit: Visit, of: str, draw: Draw, *, whole: bool, at_once_s: float = _AT_ONCE_S
) -> Markup | None:
    """Return a part of a page; None while it is being drawn, unless the whole page was asked for.

    `of` is all that the part follows from beside language and units; a page that is to be there at once waits
    `at_once_s` for it, which is what reading a kept drawing takes. Raises what `draw` raises.
    """
    drawing = visit.here.drawing_desk.kept.drawing(f"{visit.words.tag}\n{of}", draw)
    await asyncio.wait({drawing}, timeout=None if whole else at_once_s)
    return Markup(drawing.result().body.decode()) if drawing.done() else None


async def printed(visit: Visit, page: str, name: str) -> Response:
    """Return a page as a PDF of that name; raises what a worker may raise."""
    from truepose.reports.paper import pdf_of

    of = f"pdf {drawn_of(page.encode()).sha256}"
    desk = visit.here.drawing_desk
    drawn = await desk.kept.drawn(of, lambda: desk.draw(pdf_of, page))
    named = {"Content-Disposition": f'inline; filename="{name}"'}
    return sent(visit.request, drawn.body, "application/pdf", named)
