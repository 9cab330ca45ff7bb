"""Devices of the cell: state, connect, disconnect."""

from truepose.web.api.cells import DeviceReply, device_reply
from truepose.web.context import Here
from truepose.web.resources import ACT, Counted, Name, listing, problems, resource

router = resource("/devices", tags=["devices"])


@router.get("", responses=listing(422))
async def list_devices(here: Here, paging: Counted) -> list[DeviceReply]:
    """List the devices and the state of their links."""
    return paging.of(here.rack.statuses(), device_reply)


@router.get("/{name}", responses=problems(404, 422))
async def get_device(here: Here, name: Name) -> DeviceReply:
    """Show a device."""
    return device_reply(here.rack.status(name))


@router.post("/{name}/connect", responses=ACT)
async def connect_device(here: Here, name: Name) -> DeviceReply:
    """Open the link to a device and ask it who it is; 503 with a sentence where it does not answer."""
    return device_reply(await here.rack.connect(name))


@router.post("/{name}/disconnect", responses=problems(404, 409, 422))
async def disconnect_device(here: Here, name: Name) -> DeviceReply:
    """Close the link to a device; refused while a session holds it."""
    return device_reply(await here.rack.disconnect(name))
