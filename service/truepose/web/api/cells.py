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
    """Address of one instrument of a simulated cell; any client of its protocol may connect to read it."""

    device: str = Field(examples=["tracker"])
    protocol: str = Field(examples=["emscon"])
    host: str = Field(examples=["127.0.0.1"])
    port: int = Field(examples=[40123])


class NestReply(Reply):
    """Position of a nest, with its uncertainty."""

    nest: int = Field(description="Number of the nest, starting at 1.", examples=[1])
    centre_mm: Point | None = Field(
        description="Position of the centre; null if it must be identified from the data."
    )
    standard_uncertainty_mm: float | None = Field(examples=[0.002])


class CellReply(Reply):
    """A cell: its robot, instruments and artefacts."""

    name: str = Field(examples=["Simulated cell irb120-tilted"])
    robot: str = Field(description="Name of the robot, as in the list of robots.", examples=["ABB IRB 120"])
    robot_serial_number: str = Field(examples=["120-500123"])
    joints: int = Field(description="Number of joints.", examples=[6])
    simulated: bool = Field(description="True if no real robot or instrument takes part.")
    scenario: str | None = Field(
        description="Scenario of the simulated cell; null for a real cell.", examples=["irb120-tilted"]
    )
    endpoints: list[EndpointReply] = Field(
        description="Endpoints of the simulated cell; empty for a real cell."
    )
    devices: list[str] = Field(description="Names of the devices.", examples=[["tracker", "robot"]])
    tool_nests: list[NestReply] = Field(description="Tool nests, in the flange frame.")
    fixed_nests: list[NestReply] = Field(description="Fixed nests, in the world frame.")
    load: str = Field(description="Payload of the robot, from the cell file.", examples=["2.7 kg"])
    warm_up: str = Field(description="Warm-up, from the cell file.", examples=["30 min"])
    people: list[str] = Field(
        description="People permitted to confirm, from the cell file; empty if any name is accepted.",
        examples=[["Ada Byron", "Grace Hopper"]],
    )


class DeviceReply(Reply):
    """A device of the cell and the state of its connection."""

    name: str = Field(examples=["tracker"])
    kind: DeviceKind = Field(examples=["tracker"])
    driver: str = Field(examples=["leica_emscon"])
    protocol: str = Field(examples=["emscon"])
    connected: bool
    session_id: int | None = Field(description="Session that uses the device; null if none.")
    fault: str | None = Field(
        description="Reason why the last connection attempt failed; null if it did not fail."
    )
    manufacturer: str | None = Field(
        description="Manufacturer reported by the device.", examples=["Leica Geosystems"]
    )
    model: str | None = Field(examples=["AT401"])
    firmware: str | None = Field(examples=["2.0"])
    serial_number: str | None = Field(
        description="Serial number reported by the device, otherwise the one in the cell file."
    )
    expected_serial_number: str | None = Field(
        description="Serial number in the cell file; null if not stated."
    )
    answered_serial_number: str | None = Field(
        description="Serial number last reported by the device; null if it reported none."
    )
    foreign: bool = Field(description="True if a device other than the one in the cell file responded.")
    certificate: str = Field(
        description="Certificate, from the cell file; empty if a different device responded."
    )
    certificate_expires: str = Field(description="Expiry date of the certificate (ISO); empty if not stated.")


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
    """List the cells of this service, which is the one in its cell file."""
    return paging.of([here.cell], lambda cell: cell_reply(cell, here.endpoints))


@router.get("/{name}", responses=problems(404, 422))
async def get_cell(here: Here, name: Name) -> CellReply:
    """Return a cell: robot, devices and artefacts."""
    if name != here.cell.name:
        raise HTTPException(404, f"There is no cell '{name}'; this service has '{here.cell.name}'.")
    return cell_reply(here.cell, here.endpoints)


devices_router = resource("/devices", tags=["devices"])


@devices_router.get("", responses=listing(422))
async def list_devices(here: Here, paging: Counted) -> list[DeviceReply]:
    """List the devices and the state of their connections."""
    return paging.of(here.rack.statuses(), device_reply)


@devices_router.get("/{name}", responses=problems(404, 422))
async def get_device(here: Here, name: Name) -> DeviceReply:
    """Return a device."""
    return device_reply(here.rack.status(name))


@devices_router.post("/{name}/connect", responses=ACT)
async def connect_device(here: Here, name: Name) -> DeviceReply:
    """Connect to a device and ask it to identify itself; 503 if it does not respond."""
    return device_reply(await here.rack.connect(name))


@devices_router.post("/{name}/disconnect", responses=problems(404, 409, 422))
async def disconnect_device(here: Here, name: Name) -> DeviceReply:
    """Disconnect from a device; refused while a session uses it."""
    return device_reply(await here.rack.disconnect(name))
