"""What the plant handed down, for people: a model becomes one of this cell when somebody accepts it."""

from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.storage.leaving.handed_down import HandedDownRepository
from truepose.web.visiting.moments import moment
from truepose.web.visiting.visits import Visited

router = APIRouter(prefix="/hand-downs", include_in_schema=False)
_MOST: Final = 500


@router.get("", response_class=HTMLResponse)
async def handed_down_page(visit: Visited) -> HTMLResponse:
    """List what was handed down, the latest first, with who accepted or used it."""
    found = await HandedDownRepository(visit.here.database).newest(_MOST)
    return visit.page("results/hand_downs.html", hand_downs=found, moment=moment)
