"""What a client says of ballbar sessions: which one to plan, and which button was pressed."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from truepose.domain.ballbar import (
    BallbarPlan,
    PlannedAway,
    PlannedPlacement,
    PlannedPose,
    PlannedSetup,
    SpherePlanRequest,
)
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model
from truepose.domain.robot import FramePlacement
from truepose.messages.message import message
from truepose.sessions.ballbar.planning import BallbarPlanRequest
from truepose.web.api.sessions.schemas import AngleDeg
from truepose.web.schemas import (
    NUMBER_LIMIT,
    VISIBLE,
    Number,
    Request,
    example,
    whole,
)

JointsDeg = Annotated[
    list[AngleDeg],
    Field(min_length=1, max_length=32, description="Joint angles.", examples=[[0, 45, -30, 0, 30, 0]]),
]
CoordinateMm = Annotated[float, Field(ge=-20_000, le=20_000)]  # beyond any robot that a person stands beside
PointMm = Annotated[list[CoordinateMm], Field(min_length=3, max_length=3)]
Way = Annotated[
    list[JointsDeg], Field(max_length=50, description="Collision-free path from the previous configuration.")
]
BasePoint = Annotated[int, Field(ge=1, le=4)]
LegPoints = Annotated[
    list[Annotated[BasePoint, BeforeValidator(whole)]], Field(min_length=2, max_length=2, examples=[[2, 3]])
]


class SetupRequest(Request):
    """Configuration in which the robot holds the setting ball while a cup is clamped on it."""

    base_point: BasePoint
    joints_deg: JointsDeg
    via_deg: Way = Field(default_factory=list)


class AwayRequest(Request):
    """Waiting configuration of the arm after the last cup, while a person reaches the tool and the cups."""

    joints_deg: JointsDeg
    via_deg: Way = Field(default_factory=list)


class PoseRequest(Request):
    """A configuration with its lengths, each given by base point and tool point."""

    config: Number = Field(description="Number of the pose, unique in the session.", examples=[1])
    joints_deg: JointsDeg
    legs: list[LegPoints] = Field(
        min_length=1,
        max_length=12,
        description="Pairs of points between which the ballbar is connected, in this order.",
    )
    aimed_mm: list[Annotated[float, Field(gt=0, le=5000)]] | None = Field(
        None, description="Target length for each pair of points; null if all lengths are nominal."
    )
    via_deg: Way = Field(default_factory=list)


class PlacementRequest(Request):
    """A placement of the base fixture; if set-ups and poses are omitted, the service chooses them."""

    x_mm: CoordinateMm = Field(
        description="Position of B1 in the world frame; B2 is on the x axis of the fixture frame."
    )
    y_mm: CoordinateMm
    z_mm: CoordinateMm
    rx_deg: AngleDeg = 0.0
    ry_deg: AngleDeg = 0.0
    rz_deg: AngleDeg = 0.0
    cups_mm: list[PointMm] | None = Field(
        None,
        min_length=3,
        max_length=4,
        description="Cup positions in the world frame; required if poses are given.",
    )
    setups: list[SetupRequest] | None = Field(None, min_length=3, max_length=4)
    away: AwayRequest | None = Field(
        None,
        description="Configuration in which the arm waits after the last cup; null if the arm stays at "
        "the last set-up.",
    )
    poses: list[PoseRequest] | None = Field(None, min_length=1, max_length=500)


class SphereStops(Request):
    """Sphere test: configurations spread over a sphere about the ball in cup 1, with one length each."""

    method: Literal["sphere"]
    nests: list[Annotated[int, Field(ge=1, le=3)]] = Field(
        [1, 2], min_length=1, max_length=3, description="Tool nests, in the order of measurement."
    )
    configurations: int = Field(24, ge=6, le=250, description="Number of configurations per nest.")
    model_id: Number | None = Field(
        None, description="Model that commands the arm; null for the nominal model."
    )


class BallbarSessionRequest(Request):
    """A ballbar session to plan; planning does not move anything."""

    model_config = example({
        "kind": "ballbar",
        "name": "left arm, six legs",
        "poses": 24,
        "base_points": 3,
    })

    kind: Literal["ballbar"]
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm, six legs"])
    placements: list[PlacementRequest] | None = Field(
        None,
        min_length=1,
        max_length=8,
        description="Placements of the base fixture; null if the service is to suggest them.",
    )
    placement_count: int = Field(1, ge=1, le=4, description="Number of placements to suggest.")
    poses: int = Field(
        24, ge=1, le=200, description="Number of poses in the whole session, if no poses are given."
    )
    base_points: Literal[3, 4] | None = Field(
        None, description="Number of base cups; null to use the cell file."
    )
    seed: int = Field(
        0,
        ge=0,
        le=NUMBER_LIMIT,
        description="Seed of the pose selection; the same seed gives the same poses.",
    )
    plan: SphereStops | None = Field(
        None,
        description="A test at a single placement; null to measure six lengths per pose and identify a "
        "model.",
    )


class HandsRequest(Request):
    """An action for the simulated operator; each action has its own parameters."""

    model_config = example({"action": "connect", "base": 2, "tool": 3})

    action: Literal[
        "calibrator", "connect", "side", "detach", "place_base", "fit_ball", "remove_ball", "clamp",
        "pull_cable", "plug_cable", "hold", "switch_off", "switch_on",
    ]  # fmt: skip
    bars: Literal["tool", "base"] | None = Field(
        None, description="For `calibrator`: bar set of the ballbar."
    )
    base: BasePoint | None = Field(None, description="For `connect`: cup of the base.")
    tool: Annotated[int, Field(ge=1, le=3)] | None = Field(
        None, description="For `connect`: nest of the tool."
    )
    artefact: Literal["tool", "base"] | None = Field(None, description="For `side`: triangle to measure.")
    a: BasePoint | None = Field(None, description="For `side`: first point.")
    b: BasePoint | None = Field(None, description="For `side`: second point.")
    base_point: BasePoint | None = Field(None, description="For `clamp`: cup to clamp.")
    placement: Number | None = Field(
        None,
        description="For `place_base`: number of the placement. If the placement is not planned, give its "
        "coordinates as well.",
    )
    x_mm: CoordinateMm | None = None
    y_mm: CoordinateMm | None = None
    z_mm: CoordinateMm | None = None
    rx_deg: AngleDeg | None = None
    ry_deg: AngleDeg | None = None
    rz_deg: AngleDeg | None = None

    def details(self) -> dict[str, str | int | float | bool]:
        """Return what goes with the action."""
        return self.model_dump(exclude={"action"}, exclude_none=True)


def wanted_plan(wanted: BallbarSessionRequest, model: Model | None = None) -> BallbarPlanRequest:
    """Return what is wanted of a session; `model` is the one that is to command the arm."""
    places = wanted.placements or []
    given = [_given(number, place) for number, place in enumerate(places, 1)] if wanted.plan is None else []
    complete = tuple(place for place in given if place is not None)
    return wanted.into(
        BallbarPlanRequest,
        given=BallbarPlan(complete) if given and len(complete) == len(places) else None,
        frames=tuple(place.into(FramePlacement) for place in places),
        placements=wanted.placement_count,
        sphere=None if wanted.plan is None else _sphere(wanted.plan, places, model),
    )


def _sphere(wanted: SphereStops, places: list[PlacementRequest], model: Model | None) -> SpherePlanRequest:
    if any(place.poses or place.setups or place.cups_mm for place in places):
        raise ConfigurationError(message("refused.sphere_poses"))
    return wanted.into(SpherePlanRequest, nests=tuple(wanted.nests), stops=wanted.configurations, model=model)


def _given(number: int, place: PlacementRequest) -> PlannedPlacement | None:
    if place.cups_mm is None or place.setups is None or place.poses is None:
        return None
    return place.into(
        PlannedPlacement,
        number=number,
        frame=place.into(FramePlacement),
        setups=tuple(setup.into(PlannedSetup) for setup in place.setups),
        poses=tuple(pose.into(PlannedPose, placement=number) for pose in place.poses),
        away=None if place.away is None else place.away.into(PlannedAway),
    )
