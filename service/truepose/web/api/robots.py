"""Robots that are shipped with the program; a campaign brings its own table and is bound to none of them."""

from pydantic import Field

from truepose.domain.robot import JointRange, Robot
from truepose.exchange.robots.named import list_robots as shipped_robots
from truepose.exchange.robots.named import load_robot
from truepose.web.resources import Counted, Name, listing, problems, resource
from truepose.web.schemas import Reply, degrees


class JointReply(Reply):
    """A row of the DH-Modified table (after Craig), with the limits of the joint."""

    joint: int = Field(examples=[3])
    alpha_deg: float = Field(examples=[0.0])
    a_mm: float = Field(examples=[270.0])
    theta_offset_deg: float = Field(examples=[-90.0])
    d_mm: float = Field(examples=[0.0])
    sign: int = Field(description="Sign in the joint angle `sign*q + theta_offset`.", examples=[1])
    lower_limit_deg: float | None = Field(description="Lower limit of the controller.", examples=[-110.0])
    upper_limit_deg: float | None = Field(description="Upper limit of the controller.", examples=[70.0])
    calibration_from_deg: float | None = Field(
        description="Lower end of the range from which configurations are chosen."
    )
    calibration_to_deg: float | None = Field(
        description="Upper end of the range from which configurations are chosen."
    )


class RobotReply(Reply):
    """A robot supplied with the software, as specified by its manufacturer."""

    name: str = Field(description="Name used in cell files.", examples=["abb-irb-120"])
    title: str = Field(examples=["ABB IRB 120"])
    joints: list[JointReply]
    repeatability_mm: float = Field(description="Repeatability of the arm (standard deviation per axis).")
    rated_payload_kg: float | None = Field(examples=[3.0])
    source: str = Field(description="Source of the values.")


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


router = resource("/robots", tags=["robots"])


@router.get("", responses=listing(422))
async def list_robots(paging: Counted) -> list[RobotReply]:
    """List the supplied robots with their nominal tables."""
    return paging.of(shipped_robots(), lambda name: robot_reply(name, load_robot(name)))


@router.get("/{name}", responses=problems(404, 422))
async def get_robot(name: Name) -> RobotReply:
    """Return a supplied robot; 404 lists the known names."""
    return robot_reply(name, load_robot(name))
