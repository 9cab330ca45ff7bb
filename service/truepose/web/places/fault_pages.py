"""The faults of a simulated cell for people: a list of what was given, and a form for each kind."""

from typing import Any, Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.web.visiting.visits import Visited
from truepose_drivers.errors import DriverError

router = APIRouter(prefix="/faults", include_in_schema=False)
_WHEN: Final = {"from_s", "configuration", "move", "reading", "after_s", "for_s", "until_s", "count"}


@router.get("", response_class=HTMLResponse)
async def faults_page(visit: Visited) -> HTMLResponse:
    """Show what goes wrong in the cell, and what may."""
    desk = visit.here.faults_desk
    try:
        kinds = await desk.kinds() if desk.simulated else []
    except DriverError:  # the cell has ended: the page says so
        kinds = []
    return visit.page(
        "faults.html",
        simulated=desk.simulated,
        kinds=[_shown(kind) for kind in kinds],
        names={kind["kind"]: visit.words.name(kind["kind"]) for kind in kinds},
    )


def _shown(kind: dict[str, Any]) -> dict[str, Any]:
    keys = {key["key"]: key for key in kind["keys"]}
    own = [key for name, key in keys.items() if name not in _WHEN]
    return {"kind": kind["kind"], "own": own, "lasts": "for_s" in keys}
