"""Cells: this service has one."""

from fastapi import HTTPException

from truepose.web.context import Here
from truepose.web.problems import problems
from truepose.web.requests.paging import Counted, listing
from truepose.web.requests.parameters import Name
from truepose.web.resources import resource
from truepose.web.schemas.cells import CellReply, cell_reply

router = resource("/cells", tags=["cells"])


@router.get("", responses=listing(422, 503))
async def list_cells(here: Here, paging: Counted) -> list[CellReply]:
    """List the cells of this service: the one of its cell file."""
    return paging.of([here.cell], lambda cell: cell_reply(cell, here.endpoints))


@router.get("/{name}", responses=problems(404, 422))
async def get_cell(here: Here, name: Name) -> CellReply:
    """Show a cell: robot, devices and artefacts."""
    if name != here.cell.name:
        raise HTTPException(404, f"There is no cell '{name}'; this service has '{here.cell.name}'.")
    return cell_reply(here.cell, here.endpoints)
