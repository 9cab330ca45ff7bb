"""Robots that are shipped with the program; a campaign brings its own table and is bound to none of them."""

from truepose.exchange.robots.shipped import list_robots as shipped_robots
from truepose.exchange.robots.shipped import load_robot
from truepose.web.problems import problems
from truepose.web.requests.paging import Counted, listing
from truepose.web.requests.parameters import Name
from truepose.web.resources import resource
from truepose.web.schemas.cells import RobotReply, robot_reply

router = resource("/robots", tags=["robots"])


@router.get("", responses=listing(422))
async def list_robots(paging: Counted) -> list[RobotReply]:
    """List the shipped robots with their nominal tables."""
    return paging.of(shipped_robots(), lambda name: robot_reply(name, load_robot(name)))


@router.get("/{name}", responses=problems(404, 422))
async def get_robot(name: Name) -> RobotReply:
    """Show a shipped robot; 404 lists the known names."""
    return robot_reply(name, load_robot(name))
