"""Sessions that run by themselves, as a tablet shows them: where they stand, what they read and see."""

from typing import Annotated, Literal

from pydantic import Field

from truepose.exchange.results.document import FieldSource
from truepose.sessions.guide.guide import Guide, Kind, StepName
from truepose.sessions.guide.reading_tables import Status
from truepose.sessions.guide.scene import WhyHidden
from truepose.web.api.sessions.schemas import ProgressReply
from truepose.web.api.sessions.situations import IdentityReply, SituationReply, situation_reply
from truepose.web.middleware.language import Said
from truepose.web.schemas import Point, Reply

Millimetres = Annotated[float | None, Field(examples=[0.012])]
Delta = Annotated[
    Point | None, Field(description="Reading minus expected position, in the world frame; null if not known.")
]


class GuideStepReply(Reply):
    """The step to be done now."""

    id: str = Field(examples=["stop-7"])
    kind: StepName
    config: int | None
    nest: int | None = Field(description="Number of the tool nest, starting at 1.")


class LastStopReply(Reply):
    """Outcome of the latest configuration."""

    config: int
    measured: bool
    text: Said = Field(description="Reason why the configuration was not measured.")
    number: int = Field(
        description="Counter of completed attempts; distinguishes two attempts at the same configuration."
    )


class GuideReply(SituationReply):
    """Current situation of a session, for the tablet."""

    role: str = Field(examples=["calibration"])
    kind: Kind = Field(description="Kind of session.")
    robot_serial_number: str
    tool: str = Field(description="Tool that carries the tool nests; empty if not stated.")
    attachment: int = Field(description="Number of times the tool has been mounted.")
    warm_up: bool = Field(description="True if the tracker warms up before it is registered.")
    step: GuideStepReply | None = Field(description="Present step; null if nothing is left to do.")
    progress: ProgressReply
    last_stop: LastStopReply | None
    tracker_in_question: IdentityReply | None = Field(
        description="A different tracker has responded; accept it by confirming with its serial number. "
        "Null if there is none."
    )


class WarmthReply(Reply):
    """Thermal drift of the tracker, from its readings of the fixed nests."""

    time_s: list[float] = Field(description="Time of each round since the first.")
    drift_mm: list[float] = Field(description="Mean displacement of the nests since the first round.")
    ahead_mm: Millimetres = Field(
        description="Expected drift of the worst nest between two reference measurements; null if it is "
        "too early to tell."
    )
    bound_mm: Millimetres = Field(description="Upper 95 % limit of `ahead_mm`.")
    allowed_mm: float
    ready: bool


class NestRowReply(Reply):
    """A fixed nest: certified and measured position."""

    number: int
    expected_mm: Point
    readings: int
    delta_mm: Delta
    scatter_mm: Millimetres = Field(description="Standard deviation of one reading, per axis.")


class LookReply(Reply):
    """A reference measurement of the fixed nests during the session."""

    time_s: float
    moved_mm: list[float] = Field(description="Displacement of each nest since the registration.")
    worst_mm: float
    limit_mm: float
    holds: bool = Field(description="True if no nest has moved by more than the limit.")


class PlacedReply(Reply):
    """Position of the tracker in the world frame."""

    rms_mm: Millimetres = Field(description="RMS residual of the fixed nests.")
    two_face_mm: Millimetres
    scale: float | None


class PointRowReply(Reply):
    """A configuration of the plan with its result."""

    config: int
    nest: int
    status: Status
    expected_mm: Point | None = Field(
        description="Position predicted by the nominal robot; null if gauges are read."
    )
    actual_mm: Point | None
    delta_mm: Delta
    distance_mm: Millimetres
    rms_mm: Millimetres = Field(description="Scatter of the samples of the reading in use.")
    rms_limit_mm: Millimetres = Field(
        description="Scatter limit above which a reading is rejected; depends on the instrument."
    )
    readings: int = Field(description="Number of readings taken; the latest one is used.")
    reading_mm: list[float] = Field(description="Gauge readings.")
    reason: Said = Field(description="Reason why no reading is used.")


class SheetReply(Reply):
    """All readings of a session so far."""

    warmth: WarmthReply | None = Field(description="Warm-up; null if the plan does not include one.")
    nests: list[NestRowReply]
    placed: Annotated[PlacedReply | None, FieldSource("registration")]
    looks: list[LookReply]
    points: list[PointRowReply]


class SeenPointReply(Reply):
    """A fixed nest, or the tool nest of one configuration."""

    name: str = Field(examples=["F1"])
    position_mm: Point
    config: int | None
    hidden: WhyHidden | None = Field(
        description="Reason why the nest is not visible to the instrument; null if the nest is visible."
    )


class BetterPlaceReply(Reply):
    """A position from which the instrument would see more."""

    position_mm: Point
    configurations: int = Field(description="Number of configurations visible from this position.")


class GuidedSceneReply(Reply):
    """Scene of the cell, in the world frame."""

    arm_mm: list[Point]
    instrument_mm: Point | None
    placed: bool = Field(
        description="True if the position of the instrument was measured, false if it was only stated."
    )
    fixed_nests: list[SeenPointReply]
    stops: list[SeenPointReply]
    better: BetterPlaceReply | None = Field(
        description="Better position of the instrument; null if no nearby position is worth the move."
    )
    stand_mm: Point = Field(description="Position of the viewer.")
    look_at_mm: Point


class ExpectedAccuracyReply(Reply):
    """Predicted position errors for a number of configurations."""

    configurations: int
    mean_mm: float
    worst_mm: float


class OutlookReply(Reply):
    """Predicted accuracy of a session."""

    state: Literal["too_early", "known"]
    now: ExpectedAccuracyReply | None
    at_end: ExpectedAccuracyReply | None


def guide_reply(view: Guide) -> GuideReply:
    """Return a session as it travels."""
    fixed, found = view.fixed, view.standing
    cell = fixed.setup.cell
    return situation_reply(
        GuideReply,
        view.id,
        fixed.setup,
        found,
        view.attendance,
        name=fixed.name,
        role=fixed.role,
        kind=fixed.kind,
        robot_serial_number=cell.robot_serial_number,
        tool="" if cell.tool is None else cell.tool.name,
        attachment=fixed.setup.attachment,
        warm_up=bool(getattr(fixed.plan, "warm_up", False)),
        last_stop=found.last,
        tracker_in_question=view.tracker_in_question,
    )
