"""What the plant handed down, for people: a model becomes one of this cell when somebody accepts it."""

import asyncio
import math
from collections.abc import Iterable
from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse

from truepose.domain.cell.description import Cell
from truepose.domain.errors import UnsuitableModelError
from truepose.exchange.models.of_cell import HandedModel, fitting_model
from truepose.storage.leaving.handed_down import HandedDownRecord, HandedDownRepository
from truepose.web.schemas.base import NUMBER_LIMIT
from truepose.web.visiting.moments import moment
from truepose.web.visiting.visits import Visited

router = APIRouter(prefix="/hand-downs", include_in_schema=False)
_SHOWN: Final = 10  # each model among them is checked, which takes some tenths of a second
Before = Annotated[int | None, Query(ge=1, le=NUMBER_LIMIT, description="Show what was handed down earlier.")]


@router.get("", response_class=HTMLResponse)
async def handed_down_page(visit: Visited, before: Before = None) -> HTMLResponse:
    """List what was handed down, the latest first, with who accepted or used it."""
    found = await HandedDownRepository(visit.here.database).newest(_SHOWN + 1, before)
    shown = found[:_SHOWN]
    checks = await asyncio.to_thread(_checks, shown, visit.here.cell)
    return visit.page(
        "results/hand_downs.html",
        hand_downs=shown,
        older=shown[-1].id if len(found) > _SHOWN else None,
        checks=checks,
        moment=moment,
        joints=_joints,
    )


def _checks(found: Iterable[HandedDownRecord], cell: Cell) -> dict[int, HandedModel | str]:
    """Return what each model that waits for acceptance does here, or why it is none for this cell."""
    waiting = (one for one in found if one.handed_down.kind == "model" and one.model_id is None)
    return {one.id: _check(one, cell) for one in waiting}


def _check(record: HandedDownRecord, cell: Cell) -> HandedModel | str:
    try:
        return fitting_model(record.handed_down.document, cell)
    except UnsuitableModelError as error:
        return str(error)


def _joints(handed: HandedModel) -> str:
    return ", ".join(f"{math.degrees(angle):.1f}°" for angle in handed.shift.joints_rad)
