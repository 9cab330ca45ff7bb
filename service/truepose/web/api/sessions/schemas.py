"""Sessions: what is planned, where they stand, what they measured."""

from typing import Annotated, Literal

from pydantic import Field

from truepose.analysis.job_queue.tasks import CirclePlanTask, PosePlanTask
from truepose.domain.cell import Cell
from truepose.domain.session import Measured, PlannedStop, Role, SessionPlan, SessionRole, SessionState, Turn
from truepose.storage.records import SessionSetup
from truepose.web.api.sessions.situations import IdentityReply, PromptReply
from truepose.web.middleware.language import Said, SaidOrNull
from truepose.web.schemas import (
    NUMBER_LIMIT,
    VISIBLE,
    Number,
    ReasonKey,
    RecordedAt,
    RecordId,
    Reply,
    Request,
    example,
)

MOST_STOPS = 5000  # two days and nights of measuring
LengthMm = Annotated[float, Field(ge=-100_000, le=100_000)]
Component = Annotated[float, Field(ge=-1, le=1)]
AngleDeg = Annotated[float, Field(ge=-720, le=720)]  # more than any controller's range


class StopRequest(Request):
    """One configuration to visit and the tool nest to measure there."""

    config: Number = Field(description="Number of the configuration, unique in the session.", examples=[1])
    joints_deg: list[AngleDeg] = Field(
        min_length=1, max_length=32, description="Nominal joint angles.", examples=[[0, 45, -30, 0, 30, 0]]
    )
    nest: Number = Field(description="Tool nest that faces the tracker.", examples=[1])
    repeat_of: Number | None = Field(None, description="Earlier configuration with the same joints.")


class GivenStops(Request):
    """The configurations are given."""

    method: Literal["given"]
    stops: list[StopRequest] = Field(min_length=1, max_length=MOST_STOPS)


class ChosenStops(Request):
    """The configurations are chosen: by observability to calibrate, at random to validate."""

    method: Literal["choose"]
    configurations: int = Field(
        ge=1, le=MOST_STOPS, description="How many, revisits not counted.", examples=[50]
    )
    seed: int = Field(0, ge=0, le=NUMBER_LIMIT, description="The same seed chooses the same ones.")


class ProvingStops(Request):
    """Targets at random, each approached without correction and with that of a model: a proof move."""

    method: Literal["prove"]
    model_id: Number
    targets: int = Field(ge=2, le=MOST_STOPS // 2, description="Each is visited twice.", examples=[30])
    seed: int = Field(0, ge=0, le=NUMBER_LIMIT, description="The same seed chooses the same ones.")


class TurnRequest(Request):
    """Through which angles one joint is turned, in whole steps from 0."""

    joint: int = Field(ge=1, le=32, examples=[2])
    lower_deg: AngleDeg = Field(examples=[-40])
    upper_deg: AngleDeg = Field(examples=[40])
    step_deg: float = Field(ge=0.1, le=90, examples=[1])


class CircleStops(Request):
    """One joint turned at a time, up and down, all others at rest: the single-axis circle test."""

    method: Literal["circles"]
    turns: list[TurnRequest] = Field(
        [], max_length=32, description="None: as in the usual test, as far as limits and sight allow."
    )


class PoseStops(Request):
    """Poses of ISO 9283 in a cube: five in cycles, three from three directions, or one over eight hours."""

    method: Literal["iso9283"]
    test: Literal["poses", "directions", "drift"] = Field(
        "poses", description="poses: AP, RP, AD, RD. directions: vAP. drift: dAP, dRP, from cold."
    )
    edge_mm: float | None = Field(
        None,
        gt=0,
        le=10_000,
        description="Of the cube; null, as its centre: the largest that the cell has room and sight for.",
        examples=[200],
    )
    centre_mm: list[LengthMm] | None = Field(
        None,
        min_length=3,
        max_length=3,
        description="Of the cube, in the robot's base.",
        examples=[[370, 0, 400]],
    )
    plane: Literal["x+", "x-", "y+", "y-"] = Field(
        "y+", description="Diagonal plane: axis of the level edges, and whether it rises along the other."
    )
    quaternion: list[Component] | None = Field(
        None,
        min_length=4,
        max_length=4,
        description="Orientation of the last frame in the base, w first; null: it looks at the floor, or as "
        "far from there as a chosen cube needs to be seen.",
    )
    nest: Number | None = Field(
        None, description="Tool nest that stands in the poses; null: the first, or what a chosen cube shows."
    )
    cycles: int = Field(30, ge=1, le=MOST_STOPS // 9, description="The standard takes 30; of each direction.")
    approach_mm: float = Field(50, gt=0, le=500, description="Length of the last motion, for directions.")
    hours: float = Field(
        8, ge=1 / 6, le=8, description="Until the last group, for drift; it ends before where that is slow."
    )


class SessionRequest(Request):
    """A session to plan; nothing moves by planning. What is left out is as the cell file says."""

    model_config = example({
        "name": "left arm, after the collision",
        "role": "calibration",
        "plan": {"method": "choose", "configurations": 50, "seed": 1},
    })

    kind: Literal["tracker"] = Field("tracker", description="With a laser tracker or a camera.")
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm"])
    role: Role = Field(description="What the readings are for; validation readings never identify.")
    plan: Annotated[
        GivenStops | ChosenStops | ProvingStops | CircleStops | PoseStops, Field(discriminator="method")
    ]

    attachment: Number = Field(1, description="How often the tool has been mounted.")
    approach_offset_deg: Annotated[float, Field(ge=-45, le=45)] | None = Field(
        -5.0, description="Each stop is approached from here on all joints; null: mixed directions."
    )
    settle_s: float = Field(4.0, ge=0, le=600, description="Between motion and measurement.")
    measure_s: float = Field(1.0, ge=0.1, le=60, description="Length of a measurement.")
    reference_every: int = Field(10, ge=1, le=1000, description="Fixed nests are read so often.")
    registration_readings: int = Field(20, ge=1, le=1000, description="Of each fixed nest at the start.")
    two_face_check: bool = Field(True, description="Read a fixed nest in both faces at the start.")
    warm_up: bool = Field(False, description="First wait until the fixed nests show that it drifts no more.")


class ProgressReply(Reply):
    """How far a session is."""

    done: int = Field(description="Configurations measured.", examples=[12])
    skipped: int = Field(description="Configurations skipped, with a reason each.", examples=[0])
    planned: int = Field(examples=[55])
    elapsed_s: float = Field(description="Cell time.", examples=[345.2])
    remaining_s: float | None = Field(description="Cell time, from the pace so far.", examples=[1190.0])
    doing: Said = Field(examples=["measuring configuration 13"])


class SessionReply(Reply):
    """A session and where it stands."""

    id: RecordId
    recorded_at: RecordedAt
    name: str = Field(examples=["left arm"])
    role: SessionRole = Field(description="What its readings are.")
    state: SessionState
    state_since: RecordedAt
    reason: Said = Field(description="Why it is in this state.")
    reason_key: ReasonKey
    person: str | None = Field(description="Who brought it there.", examples=["Ada Byron"])
    prompt: PromptReply | None = Field(description="What a person is asked now; null: nothing.")
    trouble: SaidOrNull = Field(description="Why the session waits for the disk; null where it does not.")
    tracker_in_question: IdentityReply | None = Field(
        description="Another tracker answers; it is accepted by a confirmation that names its serial number."
    )
    motion_notice: SaidOrNull = Field(
        description="What this program cannot do once the arm moves: for whoever confirms; null: no robot."
    )
    planned: int = Field(description="Configurations in the plan, revisits included.", examples=[55])
    measured: int = Field(description="Of a ballbar session: poses with a leg at least.", examples=[12])
    skipped: int = Field(description="Of a ballbar session: poses left out.", examples=[0])
    simulated: bool = Field(description="True: no robot and no instrument take part in this session.")


class SessionDetailReply(SessionReply):
    """A session with its history."""

    progress: ProgressReply | None = Field(description="As it last said; null before the first move.")
    states: list["StateReply"] = Field(description="Every state it was in, oldest first.")
    skipped_stops: list["SkippedStopReply"]
    registration: "RegistrationReply | None" = Field(description="The tracker's place in the world.")
    identities: list[IdentityReply] = Field(description="Which devices answered, and who accepted them.")
    notes: list[Said]


class StateReply(Reply):
    """One step in the life of a session."""

    recorded_at: RecordedAt
    state: SessionState
    reason: Said
    person: str | None


class SkippedStopReply(Reply):
    """A configuration that was not measured; never filled in."""

    config: int = Field(examples=[17])
    time_s: float = Field(description="Cell time.")
    reason: Said = Field(examples=["No reflector was found within 10 mm."])


class RegistrationReply(Reply):
    """The tracker's place in the world, from the fixed nests."""

    tracker_position_mm: list[float] = Field(description="In the world frame.")
    rms_mm: float | None = Field(
        description="Of the fixed nests' residuals; null of a camera, whose place the cell file states.",
        examples=[0.006],
    )
    two_face_mm: float | None = Field(description="Half the difference between the faces.", examples=[0.004])
    scale: float | None = Field(description="Certified over measured lengths; null: scale not verified.")
    scale_standard_uncertainty: float | None


class StopReply(Reply):
    """One configuration of a plan."""

    config: int
    joints_deg: list[float]
    nest: int
    repeat_of: int | None
    group: int | None = Field(description="Of stops that belong together: a direction, an hour of drift.")


class PlanReply(Reply):
    """What a session does, in order."""

    role: Role
    measures: Measured = Field(
        description="poses where the cell has a camera; fixed nests are of points only."
    )
    approach_offset_deg: float | None
    settle_s: float
    measure_s: float
    search_radius_mm: float
    tool_speed_mm_s: float
    orientation_speed_deg_s: float
    reference_every: int
    reference_limit_mm: float
    registration_readings: int
    two_face_check: bool
    stops: list[StopReply]


def plan_of(wanted: SessionRequest, cell: Cell) -> SessionPlan:
    """Return the plan that `wanted` describes; without stops where they are to be chosen."""
    given = wanted.plan.stops if isinstance(wanted.plan, GivenStops) else []
    return wanted.into(
        SessionPlan,
        stops=tuple(stop.into(PlannedStop) for stop in given),
        tool_speed_mm_s=cell.limits.tool_speed_mm_s,
        orientation_speed_rad_s=cell.limits.orientation_speed_rad_s,
        reference_limit_mm=cell.limits.reference_mm,
        measures="points" if cell.camera is None else "poses",
    )


def plan_task(
    wanted: CircleStops | PoseStops, setup: SessionSetup, template: SessionPlan
) -> CirclePlanTask | PosePlanTask:
    """Return what a worker is asked for a test."""
    if isinstance(wanted, PoseStops):
        return wanted.into(PosePlanTask, setup=setup, template=template)
    return CirclePlanTask(setup, template, tuple(turn.into(Turn) for turn in wanted.turns))
