"""Cells, their devices and the robots that can stand in them."""

from pydantic import Field

from truepose.domain.cell.description import Cell
from truepose.domain.robot import JointRange, Robot
from truepose.operation.devices import DeviceStatus
from truepose.web.context import Endpoint
from truepose.web.schemas.base import Point, Reply, degrees
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


class JointReply(Reply):
    """One row of the DH-Modified table after Craig, and what the joint may do."""

    joint: int = Field(examples=[3])
    alpha_deg: float = Field(examples=[0.0])
    a_mm: float = Field(examples=[270.0])
    theta_offset_deg: float = Field(examples=[-90.0])
    d_mm: float = Field(examples=[0.0])
    sign: int = Field(description="The joint turns by `sign*q + theta_offset`.", examples=[1])
    lower_limit_deg: float | None = Field(description="Of the controller.", examples=[-110.0])
    upper_limit_deg: float | None = Field(description="Of the controller.", examples=[70.0])
    calibration_from_deg: float | None = Field(description="Configurations are chosen from here ...")
    calibration_to_deg: float | None = Field(description="... to here.")


class RobotReply(Reply):
    """A robot that is shipped with the program, as its maker describes it."""

    name: str = Field(description="By which cell files name it.", examples=["abb-irb-120"])
    title: str = Field(examples=["ABB IRB 120"])
    joints: list[JointReply]
    repeatability_mm: float = Field(description="Standard deviation of the arm itself, per axis.")
    rated_payload_kg: float | None = Field(examples=[3.0])
    source: str = Field(description="Where the numbers come from.")


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


def robot_reply(name: str, robot: Robot) -> RobotReply:
    """Return a shipped robot as it travels."""
    joints = [_joint(robot, index) for index in range(robot.n_joints)]
    return RobotReply.of(robot, name=name, title=robot.name, joints=joints)


def _joint(robot: Robot, index: int) -> JointReply:
    lower, upper = _range(robot.joint_limits, index)
    calibration_from, calibration_to = _range(robot.calibration_ranges, index)
    return JointReply.of(
        robot.joints[index],
        joint=index + 1,
        lower_limit_deg=lower,
        upper_limit_deg=upper,
        calibration_from_deg=calibration_from,
        calibration_to_deg=calibration_to,
    )


def _range(ranges: tuple[JointRange, ...] | None, index: int) -> tuple[float | None, float | None]:
    if ranges is None:
        return None, None
    lower, upper = degrees((ranges[index].lower_rad, ranges[index].upper_rad))
    return lower, upper
