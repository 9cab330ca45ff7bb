"""What a person is asked in a session of closed loops, and in which order. Nothing moves before all of it."""

from enum import StrEnum
from typing import Final

from truepose.domain.measurement.contacts import ContactPlan, Loop
from truepose.domain.measurement.targets import Target, TargetKind
from truepose.sequencing.engine.prompts import CELL_CLEAR


class Question(StrEnum):
    """One thing that a person does, or looks at; the name of its step."""

    FIXTURE = "fixture"
    ZERO = "zero"
    CLEAR = "clear"


_FIXED: Final[dict[Loop, str]] = {
    "probe": "Bolt what the probe touches",
    "gauges": "Bolt the fixture with the gauges",
    "wires": "Bolt the wires' drums",
    "sensor": "Bolt the ball that the sensor sees",
}
_ZEROED: Final[dict[Loop, str]] = {
    "probe": "Put the probe on its master, zero it there, and take it off: pushed in, it counts up",
    "gauges": "Put the master into the fixture, zero every gauge on it, and take it out: pushed in, they "
    "count up",
    "wires": "Put the wires' ends on their reference, zero every wire there, then hook them on the tool: "
    "pulled out, they count up",
    "sensor": "Put the sensor on its master and zero its axes",
}
_THING: Final[dict[TargetKind, str]] = {
    TargetKind.SPHERE: "sphere",
    TargetKind.PLANE: "plane",
    TargetKind.GAUGE: "gauge",
    TargetKind.WIRE: "drum",
    TargetKind.BALL: "ball",
}


def asked(question: Question, plan: ContactPlan) -> str:
    """Return what is asked."""
    match question:
        case Question.FIXTURE:
            places = ", ".join(map(_place, plan.targets))
            return f"{_FIXED[plan.loop]}, in the world: {places}; to some millimetres. Is it bolted tight?"
        case Question.ZERO:
            return f"{_ZEROED[plan.loop]}. Is that done?"
        case Question.CLEAR:
            return f"{_way_there(plan)} {CELL_CLEAR}"


def _place(target: Target) -> str:
    where = "where the plan's paper says"
    if target.place_mm is not None:
        where = "at ({:.0f}, {:.0f}, {:.0f}) mm".format(*target.place_mm)
    return f"{_THING[target.kind]} {target.number} {where}"


def _way_there(plan: ContactPlan) -> str:
    if not plan.touches:
        return "The wires stay on the tool: see that none is wound round the arm on its way."
    return (
        "The arm first goes, slowly, to where nothing is near. Where it stands beside something that it "
        "could touch on the way, drive it off by hand before you confirm."
    )
