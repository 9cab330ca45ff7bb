"""What the plant handed down, for people: a model becomes one of this cell when somebody accepts it."""

import asyncio
import math
from collections.abc import Iterable
from itertools import islice
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.domain.cell.description import Cell
from truepose.domain.errors import UnsuitableModelError
from truepose.exchange.models.of_cell import HandedModel, fitting_model
from truepose.storage.leaving.handed_down import HandedDownRecord, HandedDownRepository
from truepose.web.visiting.moments import moment
from truepose.web.visiting.visits import Visited

router = APIRouter(prefix="/hand-downs", include_in_schema=False)
_MOST: Final = 500
_MOST_CHECKED: Final = 10  # models; each takes some tenths of a second, and acceptance checks it anyway


@router.get("", response_class=HTMLResponse)
async def handed_down_page(visit: Visited) -> HTMLResponse:
    """List what was handed down, the latest first, with who accepted or used it."""
    found = await HandedDownRepository(visit.here.database).newest(_MOST)
    checks = await asyncio.to_thread(_checks, found, visit.here.cell)
    return visit.page(
        "results/hand_downs.html", hand_downs=found, checks=checks, moment=moment, joints=_joints
    )


def _checks(found: Iterable[HandedDownRecord], cell: Cell) -> dict[int, HandedModel | str]:
    """Return what each model that waits for acceptance does here, or why it is none for this cell."""
    waiting = (one for one in found if one.handed_down.kind == "model" and one.model_id is None)
    return {one.id: _check(one, cell) for one in islice(waiting, _MOST_CHECKED)}


def _check(record: HandedDownRecord, cell: Cell) -> HandedModel | str:
    try:
        return fitting_model(record.handed_down.document, cell)
    except UnsuitableModelError as error:
        return str(error)


def _joints(handed: HandedModel) -> str:
    return ", ".join(f"{math.degrees(angle):.1f}°" for angle in handed.shift.joints_rad)
