"""Sessions of closed loops: targets, what reads them, and the plan that is made of it."""

from typing import Annotated, Literal

from pydantic import Field

from truepose.domain.contacts import ContactPlan, Loop, Target, TargetDistance, TargetKind
from truepose.domain.session import Role
from truepose.planning.contacts.plan_request import ContactPlanRequest
from truepose.web.api.sessions.schemas import Component, LengthMm
from truepose.web.middleware.language import Said
from truepose.web.schemas import NUMBER_LIMIT, VISIBLE, Number, Reply, Request, example

_KINDS: dict[str, Loop] = {"sphere": "probe", "plane": "probe", "gauge": "gauges", "wire": "wires"}
MOST_TARGETS = 12
MOST_STOPS = 200
Kind = Literal["sphere", "plane", "gauge", "wire", "ball"]
SmallMm = Annotated[float, Field(ge=0, le=100)]
Place = Annotated[list[LengthMm], Field(min_length=3, max_length=3, examples=[[420, -120, 80]])]
Direction = Annotated[list[Component], Field(min_length=3, max_length=3, examples=[[0, 0, 1]])]


class TargetRequest(Request):
    """What readings are taken against; its place is found from them, and good to some millimetres here."""

    kind: Kind
    place_mm: Place = Field(description="About where it is bolted: centre, point of the plane, drum; world.")
    normal: Direction | None = Field(
        None,
        description="About the way in which readings grow: off a plane, into a gauge; of a sphere, and of a "
        "sensor's ball, the side that is open. Null: upwards.",
    )
    zero_mm: float | None = Field(
        None,
        ge=0,
        le=10_000,
        description="Distance at which it reads 0: radius of sphere and tip together, or length of the wire.",
        examples=[16.0],
    )
    zero_is_certified: bool = Field(
        True, description="False: `zero_mm` is rough, and found from the readings with all else."
    )
    zero_u_mm: SmallMm = Field(0, description="Standard uncertainty of `zero_mm`; 0: exact.")
    form_mm: SmallMm = Field(0, description="Standard deviation of its form: flatness, roundness.")


class DistanceRequest(Request):
    """A certified distance of the centres of two targets."""

    targets: list[Number] = Field(
        min_length=2, max_length=2, description="Numbers, from 1.", examples=[[1, 2]]
    )
    distance_mm: float = Field(gt=0, le=10_000, examples=[240.0123])
    u_mm: float = Field(gt=0, le=1, description="Standard uncertainty.", examples=[0.002])


class ContactSessionRequest(Request):
    """A session of closed loops to plan; its stops are chosen. Nothing moves by planning."""

    model_config = example({
        "kind": "contact",
        "name": "two spheres, left arm",
        "targets": [
            {"kind": "sphere", "place_mm": [420, -120, 80], "zero_mm": 16.0, "zero_u_mm": 0.002},
            {"kind": "sphere", "place_mm": [420, 120, 80], "zero_mm": 16.0, "zero_u_mm": 0.002},
        ],
        "distances": [{"targets": [1, 2], "distance_mm": 240.0, "u_mm": 0.003}],
        "nest": 2,
        "stops": 60,
    })

    kind: Literal["contact"]
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm"])
    targets: list[TargetRequest] = Field(
        min_length=1, max_length=MOST_TARGETS, description="Numbered from 1; gauges in the order of the cell."
    )
    distances: list[DistanceRequest] = Field([], max_length=MOST_TARGETS)
    stops: int = Field(ge=6, le=MOST_STOPS, description="How many configurations.", examples=[60])
    role: Role = Field(
        "calibration", description="What the readings are for; validation ones never identify."
    )
    nest: Number = Field(
        1,
        description="Tool nest: tip of the probe at its zero, ball, end of the wires, origin of the sensor.",
    )
    axis: Direction = Field(
        [0, 0, 1],
        description="Last frame: where the probe points, the ball sits on its stem, the sensor looks.",
    )
    stroke_mm: float = Field(5.0, gt=0, le=1000, description="Of each gauge, either way of its zero.")
    margin_mm: float = Field(1.0, ge=0, le=100, description="Of the stroke, that stays unused.")
    reading_u_mm: float = Field(0.001, gt=0, le=1, description="Standard uncertainty of a reading.")
    plane_mm: float = Field(100.0, gt=0, le=2000, description="Half the side of the square that is touched.")
    clearance_mm: float = Field(
        90.0, ge=20, le=500, description="How far off the arm is where nothing is near."
    )
    attachment: Number = Field(1, description="How often the tool has been mounted.")
    seed: int = Field(0, ge=0, le=NUMBER_LIMIT, description="The same seed chooses the same stops.")


class ContactStopReply(Reply):
    """One configuration in which gauges are read."""

    config: int
    targets: list[int] = Field(description="That the gauges read there, in their order.")
    way_deg: list[list[float]] = Field(
        description="From where nothing is near to the stop, which is the last."
    )


class ContactPlanReply(Reply):
    """What a session of closed loops does, in order."""

    loop: Loop
    role: Role
    nest: int
    stroke_mm: float
    margin_mm: float
    tool_speed_mm_s: float
    touch_speed_mm_s: float = Field(description="While something touches, or is about to.")
    questions: list[Said] = Field(description="What a person is asked before anything moves, in order.")
    minutes: float = Field(description="About, persons not included.")
    stops: list[ContactStopReply]


class ContactReadingReply(Reply):
    """What the gauges read at a stop."""

    config: int
    nest: int
    commanded_deg: list[float]
    reported_deg: list[float]
    time_s: float = Field(description="Cell time.")
    targets: list[int] = Field(description="Of each reading.")
    axes: list[int] = Field(description="Of each reading of a sensor: 0 to 2; empty for all else.")
    reading_mm: list[float]
    standard_uncertainty_mm: float


def wish_of(wanted: ContactSessionRequest) -> ContactPlanRequest:
    """Return what is wanted; the kind of the first target says what reads."""
    return wanted.into(
        ContactPlanRequest,
        loop=_KINDS.get(wanted.targets[0].kind, "sensor"),
        targets=tuple(_target(number, target) for number, target in enumerate(wanted.targets, start=1)),
        distances=tuple(
            TargetDistance((one.targets[0], one.targets[1]), one.distance_mm, one.u_mm)
            for one in wanted.distances
        ),
        axis=tuple(map(float, wanted.axis)),
        found_zeros=tuple(
            number for number, one in enumerate(wanted.targets, start=1) if not one.zero_is_certified
        ),
    )


def _target(number: int, wanted: TargetRequest) -> Target:
    return wanted.into(
        Target,
        number=number,
        kind=TargetKind(wanted.kind),
        zero_uncertainty_mm=wanted.zero_u_mm,
        place_mm=tuple(map(float, wanted.place_mm)),
        normal=None if wanted.normal is None else tuple(map(float, wanted.normal)),
    )


def plan_reply(plan: ContactPlan, questions: list[Said], minutes: float) -> ContactPlanReply:
    """Return a plan as it is shown."""
    return ContactPlanReply.of(plan, questions=questions, minutes=round(minutes, 1))
