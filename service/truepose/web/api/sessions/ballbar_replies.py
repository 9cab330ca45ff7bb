"""Ballbar sessions as they travel: where they stand, their steps, their ledger, what to draw."""

from typing import Literal

from pydantic import Field

from truepose.domain.ballbar import BarSet, StepKind, SuspicionKind
from truepose.domain.ledger import EntryKind
from truepose.exchange.results.document import Quantity
from truepose.sessions.ballbar.state import Answer, OutcomeKind
from truepose.web.api.sessions.situations import IdentityReply, SituationReply
from truepose.web.middleware.language import Said
from truepose.web.schemas import Point, RecordedAt, RecordId, Reply


class ScenePointReply(Reply):
    """A cup of the base or a nest of the tool."""

    name: str = Field(examples=["B1"])
    position_mm: Point
    kind: Literal["cup", "nest"]


class SceneReply(Reply):
    """Scene of the present step, in the world frame."""

    points: list[ScenePointReply]
    arm_mm: list[Point] = Field(
        description="Joint positions of the arm in this step, from the base to the flange frame; only the "
        "base if the others are not known."
    )
    leg: list[str] | None = Field(
        description="The two points connected by the ballbar.", examples=[["B2", "T3"]]
    )
    stand_mm: Point = Field(description="Position of the person's eyes.")
    look_at_mm: Point
    before_move_arm_mm: list[Point] | None = Field(
        description="For a motion: present joint positions of the arm, as far as known."
    )


class HandsReply(Reply):
    """Actions of the simulated operator."""

    simulated: bool = Field(description="False if a real person stands at the cell.")
    actions: list[str] = Field(examples=[["connect", "detach"]])
    holding: str = Field(
        description="Position of the ballbar; empty if hand-held.", examples=["connect base 2"]
    )


PointName = str  # B1.. of the base fixture, T1.. of the tool


class StepReply(Reply):
    """A step of the session."""

    id: str = Field(description="Permanent identifier of the step.", examples=["placement-1/pose-12/leg-2-3"])
    kind: StepKind
    placement: int | None = Field(
        description="Number of the base fixture placement, starting at 1.", examples=[1]
    )
    config: int | None = Field(description="Number of the pose.", examples=[12])
    artefact: BarSet | None = Field(description="Bar set or triangle to use.")
    points: list[PointName] | None = Field(
        description="Points connected by the ballbar.", examples=[["B2", "T3"]]
    )
    base_point: int | None = Field(description="Cup to clamp.", examples=[1])
    expected_mm: float | None = Field(
        description="Expected length: nominal, coded or predicted.", examples=[300.42]
    )
    attempt: int = Field(
        description="Attempt at this pose: 1 for the first, 2 for the first repetition.", examples=[1]
    )
    bars_mm: list[float] | None = Field(description="Extension bars to screw on.", examples=[[150.0, 50.0]])
    nominal_mm: float | None = Field(
        description="Nominal length of the ballbar with these bars.", examples=[300.0]
    )
    target_deg: list[float] | None = Field(description="Joint angles to which the robot moves.")


class PresentStepReply(StepReply):
    """The present step."""

    index: int = Field(description="Position of the step in the plan, starting at 1.", examples=[57])
    count: int = Field(description="Total number of steps.", examples=[431])
    confirmed: bool = Field(
        description="For a motion: true if a person has just confirmed that the cell is clear."
    )
    leg_number: int | None = Field(
        description="Number of the length within the pose, starting at 1.", examples=[4]
    )
    leg_count: int | None = Field(examples=[6])


class ListedStepReply(StepReply):
    """A step with its outcome."""

    outcome: OutcomeKind
    length_mm: float | None = Field(description="Stored length.", examples=[300.4213])
    text: Said = Field(description="Reason for skipping the step, or result message.")


class StepsReply(Reply):
    """All steps of a session, including completed and skipped ones."""

    steps: list[ListedStepReply]


class SuspicionReply(Reply):
    """A reading that contradicts the requested pair of points; it is not stored."""

    kind: SuspicionKind
    asked: list[PointName] = Field(examples=[["B2", "T3"]])
    suspected: list[PointName] | None = Field(description="Pair of points that matches the reading.")
    length_mm: float = Field(examples=[300.1])
    expected_mm: float | None = Field(examples=[300.4])


class BallbarProgressReply(Reply):
    """Progress of a session; readings include those of the calibrator."""

    readings: int = Field(examples=[57])
    planned: int = Field(examples=[431])
    skipped_poses: int = Field(examples=[1])
    elapsed_s: float = Field(description="Elapsed cell time of the session.", examples=[600.0])
    remaining_s: float | None = Field(
        description="Estimated remaining time at the present operator's pace.", examples=[5400.0]
    )
    pace_s_per_reading: float | None = Field(
        description="Average time per reading; null before the first reading.", examples=[9.8]
    )


class ActingReply(Reply):
    """The tablet whose commands are accepted."""

    tablet: str
    person: str


class LastOutcomeReply(Reply):
    """The most recently completed step and its outcome."""

    step_id: str
    kind: OutcomeKind
    length_mm: float | None
    text: Said


class BallbarSessionReply(SituationReply):
    """Current situation of a ballbar session."""

    kind: Literal["ballbar"] = Field(description="Kind of session.")
    result_url: str = Field(
        description="Page of the result, or of the possible next actions.", examples=["/sessions/3/result"]
    )
    step: PresentStepReply | None = Field(description="Present step; null if nothing is left to do.")
    suspicion: SuspicionReply | None
    main_answer: Answer | None = Field(description="Answer that the tablet suggests first.")
    swaps_can_be_seen: bool = Field(
        description="True if the lengths of this pose are predicted well enough to detect swapped lengths."
    )
    legs_alike: list[list[list[PointName]]] = Field(
        description="Pairs of ballbar lengths in the present pose that could be swapped without being "
        "detected.",
        examples=[[[["B1", "T1"], ["B2", "T2"]]]],
    )
    unseen_swaps_poses: list[int] = Field(
        description="Remaining poses in which swapped lengths are unlikely to be detected during "
        "measurement.",
        examples=[[1, 2, 3, 4]],
    )
    unseen_swaps: str = Field(
        description="Consequence of undetectable swaps, and remedy; empty if there are no such swaps."
    )
    ballbar_attached: bool = Field(
        description="True if the ballbar is attached, as far as known; the robot does not move while this "
        "is true."
    )
    progress: BallbarProgressReply
    acting: ActingReply | None
    last_outcome: LastOutcomeReply | None
    ballbar_in_question: IdentityReply | None = Field(
        description="A different ballbar has responded; accept it by confirming with its serial number. "
        "Null if there is none."
    )


class LengthReply(Reply):
    """A stored length, with all quantities from which it was calculated."""

    length_mm: float = Field(description="Length: calibrator length + deviation - zero.", examples=[300.4213])
    deviation_mm: float
    zero_mm: float = Field(description="Ballbar deviation shown on the calibrator.")
    standard_uncertainty_mm: float
    spread_mm: float
    samples: int
    initialisation: int = Field(
        description="Number of the latest initialisation in the session, starting at 1."
    )
    by_hand: bool = Field(description="True if stored with the button, false if stored automatically.")
    temperature_c: Quantity
    instrument_serial: str
    certificate: str
    certificate_expires: str = Field(description="Expiry date of the certificate (ISO); empty if not stated.")
    time_s: float = Field(description="Cell time at the end of the measuring window.")


class ArrivalReply(Reply):
    """Configuration in which the robot came to rest."""

    commanded_deg: list[float]
    reported_deg: list[float]
    direction: list[int] = Field(
        description="Direction of each joint's last motion: 1, -1, or 0 if it has never moved."
    )
    time_s: float


class PreCalibrationReply(Reply):
    """Result of the pre-calibration halfway through the session."""

    rms_mm: float = Field(description="RMS residual of the lengths used.")
    configurations: int
    exchanged: list[int] = Field(description="Poses with swapped lengths, which must be measured again.")


class EntryReply(Reply):
    """An entry of the ledger; entries are appended and never changed."""

    number: RecordId
    recorded_at: RecordedAt
    time_s: float = Field(description="Cell time of the entry.")
    person: str | None
    tablet: str | None
    key: str | None = Field(description="Idempotency-Key of the request that caused the entry.")
    step_id: str
    kind: EntryKind
    text: Said
    length: LengthReply | None
    arrival: ArrivalReply | None
    suspicion: SuspicionReply | None
    precalibration: PreCalibrationReply | None
    identity: IdentityReply | None = Field(description="Device that responded or was accepted.")


class LedgerReply(Reply):
    """A section of the ledger, oldest entry first."""

    entries: list[EntryReply]
