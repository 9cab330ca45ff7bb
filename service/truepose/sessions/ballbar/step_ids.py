"""Names of steps: how they are made and what they tell; the ledger knows steps by these names only.

tool/side-1-2, placement-1/cup-2/move, placement-1/pose-12/leg-2-3, placement-1/pose-12/again/leg-2-3
"""

from typing import Final

from truepose.domain.ballbar import StepKind

TOOL: Final = "tool"

_KINDS: Final = {
    "initialise": StepKind.INITIALISE,
    "side": StepKind.MEASURE_SIDE,
    "place": StepKind.PLACE_BASE,
    "ball": StepKind.FIT_BALL,
    "move": StepKind.MOVE,
    "clamp": StepKind.CLAMP_CUP,
    # Written together here, since the kind is told by what stands before the first hyphen; its step is called
    # "ball-out".
    "ballout": StepKind.REMOVE_BALL,
    "leg": StepKind.CONNECT_LEG,
    "detach": StepKind.DETACH,
    "precalibrate": StepKind.PRECALIBRATE,
}


def kind_of(step_id: str) -> StepKind | None:
    """Return what the step of that name asks for; None where no step has such a name."""
    last = step_id.rsplit("/", 1)[-1].replace("ball-out", "ballout")
    return _KINDS.get(last.split("-", 1)[0])


def group_of(step_id: str) -> str:
    """Return the group of a step: one stop of the arm, or the sides of one triangle."""
    return step_id.rpartition("/")[0]


def group_with_zero(step_id: str) -> str:
    """Return the group whose readings count from an initialisation, also from one that came in between."""
    return group_of(listed_step(step_id))


def listed_step(step_id: str) -> str:
    """Return the step of the agenda that a step is, or that it must come before."""
    # A step that had to come in between is named after the one that it came before:
    # "placement-1/pose-12/leg-2-3/initialise".
    group = group_of(step_id)
    return group if kind_of(group) is not None else step_id


def is_of_a_pose(step_id: str) -> bool:
    """Whether the step belongs to a pose."""
    return "/pose-" in step_id


def is_of_a_stop(step_id: str) -> bool:
    """Whether the step is done while the arm rests at the stop of its group."""
    return "/pose-" in step_id or "/cup-" in step_id


def placement(number: int) -> str:
    """Return the name of a placement of the base fixture."""
    return f"placement-{number}"


def cup(place: str, base_point: int) -> str:
    """Return the group of the steps that clamp one cup."""
    return f"{place}/cup-{base_point}"


def away(place: str) -> str:
    """Return the group of the motion off the cups once all are clamped."""
    return f"{place}/away"


def pose(place: str, config: int, attempt: int) -> str:
    """Return the group of the steps of one attempt at a pose."""
    # Names are kept in ledgers: they never change, and storage counts attempts by them (`pose_counts`).
    again = {1: "", 2: "/again"}.get(attempt, f"/again-{attempt - 1}")
    return f"{place}/pose-{config}{again}"


def initialise(group: str) -> str:
    """Return the step that reads the zero of a group; of a reading: the one that must come before it."""
    return f"{group}/initialise"


def side(group: str, points: tuple[int, int]) -> str:
    """Return the step that measures one side of a triangle."""
    return f"{group}/side-{points[0]}-{points[1]}"


def leg(group: str, points: tuple[int, int]) -> str:
    """Return the step that measures one leg of a pose."""
    return f"{group}/leg-{points[0]}-{points[1]}"


def move(group: str) -> str:
    """Return the step in which the arm comes to the stop of a group."""
    return f"{group}/move"


def detach(group: str) -> str:
    """Return the step that takes the ballbar off; of a move: the one that must come before it."""
    return f"{group}/detach"


def ball(group: str) -> str:
    """Return the step that fits the setting ball; of a cup: the one that must come before it."""
    return f"{group}/ball"


def points_of(step_id: str) -> tuple[int, int]:
    """Return the two points of a side or a leg from the name of its step."""
    _, first, second = step_id.rsplit("/", 1)[-1].split("-")
    return int(first), int(second)
