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
    """What a page draws of the present step, in the world."""

    points: list[ScenePointReply]
    arm_mm: list[Point] = Field(
        description="From the base to the last frame, for this step; the base alone: not known."
    )
    leg: list[str] | None = Field(
        description="The two points that the ballbar joins.", examples=[["B2", "T3"]]
    )
    stand_mm: Point = Field(description="The person's eyes.")
    look_at_mm: Point
    before_move_arm_mm: list[Point] | None = Field(
        description="Of a motion: where the arm is now, as far as known."
    )


class HandsReply(Reply):
    """What simulated hands can do."""

    simulated: bool = Field(description="False: a person stands at the cell.")
    actions: list[str] = Field(examples=[["connect", "detach"]])
    holding: str = Field(description="Where the ballbar is; empty: in the hand.", examples=["connect base 2"])


PointName = str  # B1.. of the base fixture, T1.. of the tool


class StepReply(Reply):
    """One thing to do."""

    id: str = Field(description="Stable name of the step.", examples=["placement-1/pose-12/leg-2-3"])
    kind: StepKind
    placement: int | None = Field(description="Of the base fixture, from 1.", examples=[1])
    config: int | None = Field(description="Number of the pose.", examples=[12])
    artefact: BarSet | None = Field(description="Which bars, or which triangle.")
    points: list[PointName] | None = Field(description="What the ballbar joins.", examples=[["B2", "T3"]])
    base_point: int | None = Field(description="The cup to clamp.", examples=[1])
    expected_mm: float | None = Field(description="Nominal, coded or foreseen length.", examples=[300.42])
    attempt: int = Field(description="Of the pose; 2 when it is tried again.", examples=[1])
    bars_mm: list[float] | None = Field(description="Extension bars to screw on.", examples=[[150.0, 50.0]])
    nominal_mm: float | None = Field(description="Of the ballbar with these bars.", examples=[300.0])
    target_deg: list[float] | None = Field(description="Where the robot moves.")


class PresentStepReply(StepReply):
    """The step that is to be done now."""

    index: int = Field(description="Its place among all steps, from 1.", examples=[57])
    count: int = Field(description="Of all steps.", examples=[431])
    confirmed: bool = Field(description="Of a motion: a person has just said that the cell is clear.")
    leg_number: int | None = Field(description="Its place among the legs of the pose.", examples=[4])
    leg_count: int | None = Field(examples=[6])


class ListedStepReply(StepReply):
    """A step with what became of it."""

    outcome: OutcomeKind
    length_mm: float | None = Field(description="As stored.", examples=[300.4213])
    text: Said = Field(description="Why it was skipped, or what was said.")


class StepsReply(Reply):
    """All steps of a session, done and skipped ones included."""

    steps: list[ListedStepReply]


class SuspicionReply(Reply):
    """A reading that contradicts the pair that was asked for; it is not stored."""

    kind: SuspicionKind
    asked: list[PointName] = Field(examples=[["B2", "T3"]])
    suspected: list[PointName] | None = Field(description="The pair that it goes with.")
    length_mm: float = Field(examples=[300.1])
    expected_mm: float | None = Field(examples=[300.4])


class BallbarProgressReply(Reply):
    """How far a session is; readings include those of the calibrator."""

    readings: int = Field(examples=[57])
    planned: int = Field(examples=[431])
    skipped_poses: int = Field(examples=[1])
    elapsed_s: float = Field(description="Cell time in which the session ran.", examples=[600.0])
    remaining_s: float | None = Field(description="From this operator's own pace.", examples=[5400.0])
    pace_s_per_reading: float | None = Field(description="Null before the first.", examples=[9.8])


class ActingReply(Reply):
    """The one tablet whose acts count."""

    tablet: str
    person: str


class LastOutcomeReply(Reply):
    """The step that ended last, and how."""

    step_id: str
    kind: OutcomeKind
    length_mm: float | None
    text: Said


class BallbarSessionReply(SituationReply):
    """A ballbar session and where it stands."""

    kind: Literal["ballbar"] = Field(description="What measures in it.")
    result_url: str = Field(
        description="Page of what it came to, or of what can be made of it.", examples=["/sessions/3/result"]
    )
    step: PresentStepReply | None = Field(description="Null: nothing is left to do.")
    suspicion: SuspicionReply | None
    main_answer: Answer | None = Field(description="To the suspicion, as the tablet offers it first.")
    swaps_can_be_seen: bool = Field(
        description="Lengths of this pose are foreseen well enough that exchanged legs show."
    )
    legs_alike: list[list[list[PointName]]] = Field(
        description="Pairs of legs of the present pose whose exchange would not show.",
        examples=[[[["B1", "T1"], ["B2", "T2"]]]],
    )
    unseen_swaps_poses: list[int] = Field(
        description="Poses ahead in which an exchange of legs is hardly seen when it is made.",
        examples=[[1, 2, 3, 4]],
    )
    unseen_swaps: str = Field(description="What that means and what helps, as a sentence; empty: nothing.")
    ballbar_attached: bool = Field(description="As far as known; nothing moves meanwhile.")
    progress: BallbarProgressReply
    acting: ActingReply | None
    last_outcome: LastOutcomeReply | None
    ballbar_in_question: IdentityReply | None = Field(
        description="Another ballbar answers; it is accepted by a confirmation that names its serial number."
    )


class LengthReply(Reply):
    """A length as it was stored, with everything that it rests on."""

    length_mm: float = Field(description="Calibrator + deviation - zero.", examples=[300.4213])
    deviation_mm: float
    zero_mm: float = Field(description="What the ballbar showed on the calibrator.")
    standard_uncertainty_mm: float
    spread_mm: float
    samples: int
    initialisation: int = Field(description="Number of the last one in the session, from 1.")
    by_hand: bool = Field(description="Stored by the button, not by itself.")
    temperature_c: Quantity
    instrument_serial: str
    certificate: str
    certificate_expires: str = Field(description="ISO date; empty where nobody said it.")
    time_s: float = Field(description="Cell time, end of the window.")


class ArrivalReply(Reply):
    """Where the robot came to rest."""

    commanded_deg: list[float]
    reported_deg: list[float]
    direction: list[int] = Field(description="Sign of each joint's last motion; 0 where it never moved.")
    time_s: float


class PreCalibrationReply(Reply):
    """What was found halfway."""

    rms_mm: float = Field(description="Of the legs it rests on.")
    configurations: int
    exchanged: list[int] = Field(description="Poses whose legs were confused: to be measured again.")


class EntryReply(Reply):
    """One line of what happened; appended, never changed."""

    number: RecordId
    recorded_at: RecordedAt
    time_s: float = Field(description="Cell time.")
    person: str | None
    tablet: str | None
    key: str | None = Field(description="Idempotency-Key of the request that caused it.")
    step_id: str
    kind: EntryKind
    text: Said
    length: LengthReply | None
    arrival: ArrivalReply | None
    suspicion: SuspicionReply | None
    precalibration: PreCalibrationReply | None
    identity: IdentityReply | None = Field(description="Which device answered, or was accepted.")


class LedgerReply(Reply):
    """A part of the ledger, oldest first."""

    entries: list[EntryReply]
