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
    """A configuration to visit and the tool nest to measure there."""

    config: Number = Field(description="Number of the configuration, unique in the session.", examples=[1])
    joints_deg: list[AngleDeg] = Field(
        min_length=1, max_length=32, description="Nominal joint angles.", examples=[[0, 45, -30, 0, 30, 0]]
    )
    nest: Number = Field(description="Tool nest that faces the tracker.", examples=[1])
    repeat_of: Number | None = Field(None, description="Earlier configuration with the same joints.")


class GivenStops(Request):
    """Configurations given by the client."""

    method: Literal["given"]
    stops: list[StopRequest] = Field(min_length=1, max_length=MOST_STOPS)


class ChosenStops(Request):
    """Configurations chosen by the service: by observability for calibration, at random for validation."""

    method: Literal["choose"]
    configurations: int = Field(
        ge=1,
        le=MOST_STOPS,
        description="Number of distinct configurations, not counting repeat measurements.",
        examples=[50],
    )
    seed: int = Field(
        0,
        ge=0,
        le=NUMBER_LIMIT,
        description="Seed of the selection; the same seed gives the same configurations.",
    )


class ProvingStops(Request):
    """Proof move: random targets, each approached without and with correction by a model."""

    method: Literal["prove"]
    model_id: Number
    targets: int = Field(
        ge=2, le=MOST_STOPS // 2, description="Number of targets; each is visited twice.", examples=[30]
    )
    seed: int = Field(
        0, ge=0, le=NUMBER_LIMIT, description="Seed of the selection; the same seed gives the same targets."
    )


class TurnRequest(Request):
    """Range of angles of one joint, in whole steps from 0."""

    joint: int = Field(ge=1, le=32, examples=[2])
    lower_deg: AngleDeg = Field(examples=[-40])
    upper_deg: AngleDeg = Field(examples=[40])
    step_deg: float = Field(ge=0.1, le=90, examples=[1])


class CircleStops(Request):
    """Circle test: one joint at a time is turned in both directions while all others are at rest."""

    method: Literal["circles"]
    turns: list[TurnRequest] = Field(
        [],
        max_length=32,
        description="Joints to turn; if empty, the joints of the standard test, as far as limits and line "
        "of sight allow.",
    )


class PoseStops(Request):
    """ISO 9283 test in a cube: five poses in cycles, three from three directions, or one over eight hours."""

    method: Literal["iso9283"]
    test: Literal["poses", "directions", "drift"] = Field(
        "poses",
        description="`poses`: AP, RP, AD, RD. `directions`: vAP. `drift`: dAP, dRP from a cold start.",
    )
    edge_mm: float | None = Field(
        None,
        gt=0,
        le=10_000,
        description="Edge length of the cube. Null, together with a null centre: the largest cube with "
        "clearance and line of sight in the cell.",
        examples=[200],
    )
    centre_mm: list[LengthMm] | None = Field(
        None,
        min_length=3,
        max_length=3,
        description="Centre of the cube, in the base frame of the robot.",
        examples=[[370, 0, 400]],
    )
    plane: Literal["x+", "x-", "y+", "y-"] = Field(
        "y+",
        description="Diagonal plane of the cube: axis of its horizontal edges, and whether it rises "
        "(+) or falls (-) along the other axis.",
    )
    quaternion: list[Component] | None = Field(
        None,
        min_length=4,
        max_length=4,
        description="Orientation of the flange frame in the base frame, w first. Null: the tool points "
        "down; in an automatically chosen cube it is tilted as far as line of sight requires.",
    )
    nest: Number | None = Field(
        None,
        description="Tool nest measured at the poses. Null: the first nest or, in an automatically chosen "
        "cube, the visible nest.",
    )
    cycles: int = Field(
        30,
        ge=1,
        le=MOST_STOPS // 9,
        description="Number of cycles, per direction for `directions`; the standard requires 30.",
    )
    approach_mm: float = Field(
        50, gt=0, le=500, description="Length of the final approach, for `directions`."
    )
    hours: float = Field(
        8,
        ge=1 / 6,
        le=8,
        description="Time until the last group, for `drift`; the test ends earlier if the drift has "
        "become slow.",
    )


class SessionRequest(Request):
    """A session to plan; planning does not move anything. Omitted values are taken from the cell file."""

    model_config = example({
        "name": "left arm, after the collision",
        "role": "calibration",
        "plan": {"method": "choose", "configurations": 50, "seed": 1},
    })

    kind: Literal["tracker"] = Field("tracker", description="Session with a laser tracker or a camera.")
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm"])
    role: Role = Field(
        description="Use of the readings; validation readings are never used for identification."
    )
    plan: Annotated[
        GivenStops | ChosenStops | ProvingStops | CircleStops | PoseStops, Field(discriminator="method")
    ]

    attachment: Number = Field(1, description="Number of times the tool has been mounted.")
    approach_offset_deg: Annotated[float, Field(ge=-45, le=45)] | None = Field(
        -5.0,
        description="Joint offset from which each configuration is approached, on all joints; null for "
        "mixed directions.",
    )
    settle_s: float = Field(4.0, ge=0, le=600, description="Waiting time between motion and measurement.")
    measure_s: float = Field(1.0, ge=0.1, le=60, description="Duration of a measurement.")
    reference_every: int = Field(
        10,
        ge=1,
        le=1000,
        description="Number of configurations between reference measurements of the fixed nests.",
    )
    registration_readings: int = Field(
        20, ge=1, le=1000, description="Number of readings of each fixed nest at the start."
    )
    two_face_check: bool = Field(True, description="True: measure a fixed nest in both faces at the start.")
    warm_up: bool = Field(
        False, description="True: first wait until the fixed nests show that the tracker no longer drifts."
    )


class ProgressReply(Reply):
    """Progress of a session."""

    done: int = Field(description="Number of configurations measured.", examples=[12])
    skipped: int = Field(description="Number of configurations skipped, each with a reason.", examples=[0])
    planned: int = Field(examples=[55])
    elapsed_s: float = Field(description="Elapsed cell time.", examples=[345.2])
    remaining_s: float | None = Field(
        description="Remaining cell time at the present pace.", examples=[1190.0]
    )
    doing: Said = Field(examples=["measuring configuration 13"])


class SessionReply(Reply):
    """A session and its state."""

    id: RecordId
    recorded_at: RecordedAt
    name: str = Field(examples=["left arm"])
    role: SessionRole = Field(description="Use of its readings.")
    state: SessionState
    state_since: RecordedAt
    reason: Said = Field(description="Reason for the state.")
    reason_key: ReasonKey
    person: str | None = Field(description="Person who caused the state.", examples=["Ada Byron"])
    prompt: PromptReply | None = Field(
        description="Prompt that is waiting for an answer; null if there is none."
    )
    trouble: SaidOrNull = Field(
        description="Reason why the session waits for the disk; null if it is not waiting."
    )
    tracker_in_question: IdentityReply | None = Field(
        description="A different tracker has responded; accept it by confirming with its serial number. "
        "Null if there is none."
    )
    motion_notice: SaidOrNull = Field(
        description="Limitations of this software once the arm moves, shown to the person who confirms; "
        "null without a robot."
    )
    planned: int = Field(
        description="Number of configurations in the plan, including repeat measurements.", examples=[55]
    )
    measured: int = Field(
        description="Number of configurations measured; for a ballbar session, poses with at least one "
        "length.",
        examples=[12],
    )
    skipped: int = Field(
        description="Number of configurations skipped; for a ballbar session, poses.", examples=[0]
    )
    simulated: bool = Field(description="True if the session has no real robot or instrument.")


class SessionDetailReply(SessionReply):
    """A session with its history."""

    progress: ProgressReply | None = Field(description="Latest progress; null before the first move.")
    states: list["StateReply"] = Field(description="All states of the session, oldest first.")
    skipped_stops: list["SkippedStopReply"]
    registration: "RegistrationReply | None" = Field(
        description="Position of the tracker in the world frame."
    )
    identities: list[IdentityReply] = Field(
        description="Devices that identified themselves, with the people who accepted them."
    )
    notes: list[Said]


class StateReply(Reply):
    """A state in the history of a session."""

    recorded_at: RecordedAt
    state: SessionState
    reason: Said
    person: str | None


class SkippedStopReply(Reply):
    """A configuration that was not measured; no value is substituted."""

    config: int = Field(examples=[17])
    time_s: float = Field(description="Cell time at which the configuration was skipped.")
    reason: Said = Field(examples=["No reflector was found within 10 mm."])


class RegistrationReply(Reply):
    """Position of the tracker in the world frame, from the fixed nests."""

    tracker_position_mm: list[float] = Field(description="Position of the tracker in the world frame.")
    rms_mm: float | None = Field(
        description="RMS residual of the fixed nests; null for a camera, whose position is stated in the "
        "cell file.",
        examples=[0.006],
    )
    two_face_mm: float | None = Field(
        description="Half the difference between the two faces.", examples=[0.004]
    )
    scale: float | None = Field(
        description="Ratio of certified to measured lengths; null if the scale was not verified."
    )
    scale_standard_uncertainty: float | None


class StopReply(Reply):
    """A configuration of a plan."""

    config: int
    joints_deg: list[float]
    nest: int
    repeat_of: int | None
    group: int | None = Field(
        description="Group to which the configuration belongs, such as a direction or an hour of a drift "
        "test."
    )


class PlanReply(Reply):
    """Configurations and parameters of a session, in order of measurement."""

    role: Role
    measures: Measured = Field(
        description="`poses` if the cell has a camera; fixed nests are always measured as points."
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
