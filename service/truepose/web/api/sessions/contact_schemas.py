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
    """A target for contact readings; its position is identified, so some millimetres of accuracy suffice."""

    kind: Kind
    place_mm: Place = Field(
        description="Approximate position in the world frame: centre, point on the plane, or drum."
    )
    normal: Direction | None = Field(
        None,
        description="Approximate direction in which readings increase: away from a plane, into a gauge; "
        "for a sphere or a sensor ball, the open side. Null means upwards.",
    )
    zero_mm: float | None = Field(
        None,
        ge=0,
        le=10_000,
        description="Distance at which the reading is 0: sum of the radii of sphere and tip, or length of "
        "the wire.",
        examples=[16.0],
    )
    zero_is_certified: bool = Field(
        True, description="False if `zero_mm` is approximate and must be identified from the readings."
    )
    zero_u_mm: SmallMm = Field(0, description="Standard uncertainty of `zero_mm`; 0 means exact.")
    form_mm: SmallMm = Field(0, description="Standard deviation of the form error: flatness or roundness.")


class DistanceRequest(Request):
    """Certified distance between the centres of two targets."""

    targets: list[Number] = Field(
        min_length=2,
        max_length=2,
        description="Numbers of the two targets, starting at 1.",
        examples=[[1, 2]],
    )
    distance_mm: float = Field(gt=0, le=10_000, examples=[240.0123])
    u_mm: float = Field(gt=0, le=1, description="Standard uncertainty of the distance.", examples=[0.002])


class ContactSessionRequest(Request):
    """A contact session to plan; the service chooses the configurations. Planning does not move anything."""

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
        min_length=1,
        max_length=MOST_TARGETS,
        description="Targets, numbered from 1; gauges in the order of the cell file.",
    )
    distances: list[DistanceRequest] = Field([], max_length=MOST_TARGETS)
    stops: int = Field(ge=6, le=MOST_STOPS, description="Number of configurations.", examples=[60])
    role: Role = Field(
        "calibration",
        description="Use of the readings; validation readings are never used for identification.",
    )
    nest: Number = Field(
        1,
        description="Tool nest: tip of the probe at zero, ball, end of the wires, or origin of the sensor.",
    )
    axis: Direction = Field(
        [0, 0, 1],
        description="Direction in the flange frame: of the probe, of the ball on its stem, or of the "
        "sensor's view.",
    )
    stroke_mm: float = Field(
        5.0, gt=0, le=1000, description="Stroke of each gauge to either side of its zero."
    )
    margin_mm: float = Field(1.0, ge=0, le=100, description="Part of the stroke that remains unused.")
    reading_u_mm: float = Field(0.001, gt=0, le=1, description="Standard uncertainty of a reading.")
    plane_mm: float = Field(
        100.0, gt=0, le=2000, description="Half the side length of the square to be touched."
    )
    clearance_mm: float = Field(
        90.0, ge=20, le=500, description="Distance between arm and targets in the clear position."
    )
    attachment: Number = Field(1, description="Number of times the tool has been mounted.")
    seed: int = Field(
        0,
        ge=0,
        le=NUMBER_LIMIT,
        description="Seed of the selection; the same seed gives the same configurations.",
    )


class ContactStopReply(Reply):
    """A configuration in which gauges are read."""

    config: int
    targets: list[int] = Field(description="Targets read in this configuration, in the order of the gauges.")
    way_deg: list[list[float]] = Field(
        description="Path from the clear position to the configuration, which is its last entry."
    )


class ContactPlanReply(Reply):
    """Planned configurations and motion parameters of a contact session, in order."""

    loop: Loop
    role: Role
    nest: int
    stroke_mm: float
    margin_mm: float
    tool_speed_mm_s: float
    touch_speed_mm_s: float = Field(description="Speed during contact and just before it.")
    questions: list[Said] = Field(description="Questions put to the person before anything moves, in order.")
    minutes: float = Field(description="Approximate duration, not including operator time.")
    stops: list[ContactStopReply]


class ContactReadingReply(Reply):
    """Gauge readings at a configuration."""

    config: int
    nest: int
    commanded_deg: list[float]
    reported_deg: list[float]
    time_s: float = Field(description="Cell time of the readings.")
    targets: list[int] = Field(description="Target of each reading.")
    axes: list[int] = Field(description="Sensor axis of each reading, 0 to 2; empty for other instruments.")
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
