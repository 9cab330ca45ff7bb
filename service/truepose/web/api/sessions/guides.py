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
Delta = Annotated[Point | None, Field(description="Read minus expected, in the world; null: not known.")]


class GuideStepReply(Reply):
    """What is due now."""

    id: str = Field(examples=["stop-7"])
    kind: StepName
    config: int | None
    nest: int | None = Field(description="Of the tool, 1-based.")


class LastStopReply(Reply):
    """How the newest configuration ended."""

    config: int
    measured: bool
    text: Said = Field(description="Why it was not measured.")
    number: int = Field(description="Counts ends: two of one configuration differ.")


class GuideReply(SituationReply):
    """A session and where it stands, for a tablet."""

    role: str = Field(examples=["calibration"])
    kind: Kind = Field(description="What measures in it.")
    robot_serial_number: str
    tool: str = Field(description="What carries the tool nests; empty: nobody said.")
    attachment: int = Field(description="How often the tool has been mounted.")
    warm_up: bool = Field(description="The tracker warms up before it is placed in the world.")
    step: GuideStepReply | None = Field(description="Null: nothing is left to do.")
    progress: ProgressReply
    last_stop: LastStopReply | None
    tracker_in_question: IdentityReply | None = Field(
        description="Another tracker answers; it is accepted by a confirmation that names its serial number."
    )


class WarmthReply(Reply):
    """How warm the tracker is, by what it read of the fixed nests."""

    time_s: list[float] = Field(description="Of each round, since the first.")
    drift_mm: list[float] = Field(description="Mean way of the nests since the first round.")
    ahead_mm: Millimetres = Field(description="Drift of the worst nest between two looks; null: too early.")
    bound_mm: Millimetres = Field(description="Below which that is, with 95 %.")
    allowed_mm: float
    ready: bool


class NestRowReply(Reply):
    """A fixed nest, certified and read."""

    number: int
    expected_mm: Point
    readings: int
    delta_mm: Delta
    scatter_mm: Millimetres = Field(description="Of one reading, per axis.")


class LookReply(Reply):
    """The fixed nests looked at once more."""

    time_s: float
    moved_mm: list[float] = Field(description="Of each nest since the registration.")
    worst_mm: float
    limit_mm: float
    holds: bool = Field(description="Nothing moved further than is allowed.")


class PlacedReply(Reply):
    """The tracker's place in the world."""

    rms_mm: Millimetres = Field(description="Of the fixed nests' residuals.")
    two_face_mm: Millimetres
    scale: float | None


class PointRowReply(Reply):
    """A configuration of the plan and what came of it."""

    config: int
    nest: int
    status: Status
    expected_mm: Point | None = Field(description="By the nominal robot; null where gauges are read.")
    actual_mm: Point | None
    delta_mm: Delta
    distance_mm: Millimetres
    rms_mm: Millimetres = Field(description="Scatter of the samples of the reading that counts.")
    rms_limit_mm: Millimetres = Field(description="Above which none is taken; it knows the instrument.")
    readings: int = Field(description="Readings that were taken; the newest counts.")
    reading_mm: list[float] = Field(description="Of gauges.")
    reason: Said = Field(description="Why no reading counts.")


class SheetReply(Reply):
    """Everything that a session has read so far."""

    warmth: WarmthReply | None = Field(description="Null: the plan asks for no warm-up.")
    nests: list[NestRowReply]
    placed: Annotated[PlacedReply | None, FieldSource("registration")]
    looks: list[LookReply]
    points: list[PointRowReply]


class SeenPointReply(Reply):
    """A fixed nest, or the tool nest of one configuration."""

    name: str = Field(examples=["F1"])
    position_mm: Point
    config: int | None
    hidden: WhyHidden | None = Field(description="Why the instrument does not see it; null: it does.")


class BetterPlaceReply(Reply):
    """Where the instrument would see more."""

    position_mm: Point
    configurations: int = Field(description="That are seen from there.")


class GuidedSceneReply(Reply):
    """What a page draws of the cell, in the world."""

    arm_mm: list[Point]
    instrument_mm: Point | None
    placed: bool = Field(description="Its place was measured, not only stated.")
    fixed_nests: list[SeenPointReply]
    stops: list[SeenPointReply]
    better: BetterPlaceReply | None = Field(description="Null: no place nearby is worth the way.")
    stand_mm: Point = Field(description="Of whoever looks at the picture.")
    look_at_mm: Point


class ExpectedAccuracyReply(Reply):
    """Errors of position that so many configurations promise."""

    configurations: int
    mean_mm: float
    worst_mm: float


class OutlookReply(Reply):
    """What a session promises."""

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
