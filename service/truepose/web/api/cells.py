"""Cells and their devices: this service has one cell."""

from fastapi import HTTPException
from pydantic import Field

from truepose.domain.cell import Cell
from truepose.sessions.devices import DeviceStatus
from truepose.web.context import Endpoint, Here
from truepose.web.resources import ACT, LIST, Counted, Name, listing, problems, resource
from truepose.web.schemas import Point, Reply
from truepose_drivers.api import DeviceKind


class EndpointReply(Reply):
    """Where one instrument of a simulated cell listens; any client of its protocol may look at it."""

    device: str = Field(examples=["tracker"])
    protocol: str = Field(examples=["emscon"])
    host: str = Field(examples=["127.0.0.1"])
    port: int = Field(examples=[40123])


class NestReply(Reply):
    """A nest: where it is, and how well that is known."""

    nest: int = Field(description="Number, from 1.", examples=[1])
    centre_mm: Point | None = Field(description="Null where it must be found from the data.")
    standard_uncertainty_mm: float | None = Field(examples=[0.002])


class CellReply(Reply):
    """A cell: a robot, what measures it, and the artefacts it is measured on."""

    name: str = Field(examples=["Simulated cell irb120-tilted"])
    robot: str = Field(description="Name of the robot; see robots.", examples=["ABB IRB 120"])
    robot_serial_number: str = Field(examples=["120-500123"])
    joints: int = Field(description="Number of joints.", examples=[6])
    simulated: bool = Field(description="True: no robot and no instrument take part.")
    scenario: str | None = Field(description="Of the simulated cell.", examples=["irb120-tilted"])
    endpoints: list[EndpointReply] = Field(description="Of the simulated cell; empty for a real one.")
    devices: list[str] = Field(description="Names of the devices.", examples=[["tracker", "robot"]])
    tool_nests: list[NestReply] = Field(description="In the frame of the last joint.")
    fixed_nests: list[NestReply] = Field(description="In the world frame.")
    load: str = Field(description="What the robot carries, as the cell file says.", examples=["2.7 kg"])
    warm_up: str = Field(description="As the cell file says.", examples=["30 min"])
    people: list[str] = Field(
        description="Who may confirm, as the cell file announces them; empty: whoever gives a name.",
        examples=[["Ada Byron", "Grace Hopper"]],
    )


class DeviceReply(Reply):
    """A device of the cell and the state of its link."""

    name: str = Field(examples=["tracker"])
    kind: DeviceKind = Field(examples=["tracker"])
    driver: str = Field(examples=["leica_emscon"])
    protocol: str = Field(examples=["emscon"])
    connected: bool
    session_id: int | None = Field(description="The session that holds the device.")
    fault: str | None = Field(description="Why the last attempt to connect failed.")
    manufacturer: str | None = Field(description="As the device said itself.", examples=["Leica Geosystems"])
    model: str | None = Field(examples=["AT401"])
    firmware: str | None = Field(examples=["2.0"])
    serial_number: str | None = Field(description="As the device said, else as the cell file says.")
    expected_serial_number: str | None = Field(description="As the cell file says; null: it names none.")
    answered_serial_number: str | None = Field(description="As the device last said; null: it did not.")
    foreign: bool = Field(description="Another device answered than the cell file names.")
    certificate: str = Field(description="As the cell file says; empty where another device answered.")
    certificate_expires: str = Field(description="ISO date; empty where nobody said it.")


def cell_reply(cell: Cell, endpoints: tuple[Endpoint, ...]) -> CellReply:
    """Return a cell as it travels."""
    return CellReply.of(
        cell,
        cell.conditions,
        robot=cell.robot.name,
        joints=cell.robot.n_joints,
        simulated=cell.simulated is not None,
        scenario=None if cell.simulated is None else cell.simulated.scenario,
        endpoints=endpoints,
        devices=[entry.name for entry in cell.devices],
        tool_nests=[NestReply.of(nest, nest=number) for number, nest in enumerate(cell.nests, 1)],
        fixed_nests=[NestReply.of(nest, nest=number) for number, nest in enumerate(cell.fixed_nests, 1)],
    )


def device_reply(status: DeviceStatus) -> DeviceReply:
    """Return a device as it travels."""
    said, mounted, entry = status.identity, status.mounted, status.mounted.entry
    return DeviceReply.of(
        status,
        mounted,
        entry,
        manufacturer=None if said is None else said.manufacturer,
        model=None if said is None else said.model,
        firmware=None if said is None else said.firmware,
        serial_number=(entry.serial_number or None) if said is None else said.serial,
        expected_serial_number=mounted.expected_serial or None,
        answered_serial_number=status.answered_serial or None,
        foreign=status.is_foreign,
        certificate="" if status.is_foreign else entry.certificate,
        certificate_expires="" if status.is_foreign else entry.certificate_expires,
    )


router = resource("/cells", tags=["cells"])


@router.get("", responses=LIST)
async def list_cells(here: Here, paging: Counted) -> list[CellReply]:
    """List the cells of this service: the one of its cell file."""
    return paging.of([here.cell], lambda cell: cell_reply(cell, here.endpoints))


@router.get("/{name}", responses=problems(404, 422))
async def get_cell(here: Here, name: Name) -> CellReply:
    """Show a cell: robot, devices and artefacts."""
    if name != here.cell.name:
        raise HTTPException(404, f"There is no cell '{name}'; this service has '{here.cell.name}'.")
    return cell_reply(here.cell, here.endpoints)


devices_router = resource("/devices", tags=["devices"])


@devices_router.get("", responses=listing(422))
async def list_devices(here: Here, paging: Counted) -> list[DeviceReply]:
    """List the devices and the state of their links."""
    return paging.of(here.rack.statuses(), device_reply)


@devices_router.get("/{name}", responses=problems(404, 422))
async def get_device(here: Here, name: Name) -> DeviceReply:
    """Show a device."""
    return device_reply(here.rack.status(name))


@devices_router.post("/{name}/connect", responses=ACT)
async def connect_device(here: Here, name: Name) -> DeviceReply:
    """Open the link to a device and ask it who it is; 503 with a sentence where it does not answer."""
    return device_reply(await here.rack.connect(name))


@devices_router.post("/{name}/disconnect", responses=problems(404, 409, 422))
async def disconnect_device(here: Here, name: Name) -> DeviceReply:
    """Close the link to a device; refused while a session holds it."""
    return device_reply(await here.rack.disconnect(name))
