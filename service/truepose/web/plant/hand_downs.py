"""Plans and models for cells: delivered at the next visit, once, and listed with what the cell said."""

from fastapi import Response, status

from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.records import HandDown, HandDownKind
from truepose.web.plant.context import PlantHere
from truepose.web.plant.schemas import HandDownReply, HandDownRequest, hand_down_reply
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import Id, OptionalKey
from truepose.web.resources import resource

router = resource("/plant/hand-downs", tags=["plant"])


@router.post("", status_code=status.HTTP_201_CREATED, responses=problems(400, 404, 409, 413, 415, 422, 503))
async def add_hand_down(
    here: PlantHere, wanted: HandDownRequest, response: Response, key: OptionalKey
) -> HandDownReply:
    """Hand a plan or a model down to a cell. A person there uses it, or nobody does: nothing moves by it."""
    if not here.collector.knows(wanted.cell):
        raise NotInPlantError(f"There is no cell '{wanted.cell}' in the cells file of this plant.")
    told = HandDown(wanted.cell, HandDownKind(wanted.kind), wanted.name, wanted.person, wanted.document)
    number = await here.hand_downs.add(told, key)
    here.collector.visit_soon(wanted.cell)
    response.headers["Location"] = f"/api/v1/plant/hand-downs/{number}"
    return hand_down_reply(await here.hand_downs.get(number))


@router.get("", responses=listing(422, 503))
async def list_plant_hand_downs(here: PlantHere, paging: Paged) -> list[HandDownReply]:
    """List what was handed down, oldest first, with its state."""
    return paging.shown(await here.hand_downs.page(paging.page), hand_down_reply)


@router.get("/{id}", responses=problems(404, 422, 503))
async def get_plant_hand_down(here: PlantHere, id: Id) -> HandDownReply:
    """Show what was handed down, and whether the cell has it."""
    return hand_down_reply(await here.hand_downs.get(id))
