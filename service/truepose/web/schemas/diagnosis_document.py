"""The document that `truepose diagnose --json` prints, as a schema."""

from pydantic import Field

from truepose.domain.diagnosis import Confidence, HeldOut, Shape, Verdict
from truepose.web.schemas.results import Document, StatisticsDocument


class CauseDocument(Document):
    """A cause by its name."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])


class DetailDocument(Document):
    """One more number of a finding, in the unit that it names."""

    name: str = Field(examples=["order"])
    value: float | None = Field(examples=[2.0])
    unit: str = Field(examples=["1"])
    standard_uncertainty: float | None = Field(examples=[0.0])


class GainDocument(Document):
    """What the finding takes off the held-out errors."""

    rms_before_mm: float | None = Field(examples=[0.061])
    rms_after_mm: float | None = Field(examples=[0.019])
    interval_95_mm: list[float | None] = Field(
        min_length=2, max_length=2, description="Of the difference, before less after."
    )


class CurvePointsDocument(Document):
    """Further readings of a curve, as its own are."""

    x: list[float | None]
    residual: list[float | None]
    standard_uncertainty: list[float | None]


class CurveDocument(Document):
    """Residuals along one variable, with what was fitted to them; units stand beside."""

    variable: str = Field(examples=["angle of joint 4"])
    variable_unit: str = Field(examples=["deg"])
    quantity: str = Field(examples=["error of joint 4"])
    quantity_unit: str = Field(examples=["deg"])
    x: list[float | None]
    residual: list[float | None]
    standard_uncertainty: list[float | None]
    line_x: list[float | None]
    line: list[float | None]
    line_band: list[float | None] = Field(description="Half width of the 95 % band.")
    unseen: CurvePointsDocument | None = Field(
        None, description="Validation readings, which were never fitted; null where there are none to draw."
    )


class SpectrumDocument(Document):
    """Waves of one joint by their order."""

    order: list[float | None] = Field(description="Periods per turn, ascending.", examples=[[1.0, 2.0]])
    amplitude_deg: list[float | None] = Field(examples=[[0.021, 0.008]])
    standard_uncertainty_deg: list[float | None] = Field(examples=[[0.002, 0.002]])


class WorthDocument(Document):
    """How far a cause moves the tool over the calibration readings."""

    mean_mm: float | None = Field(examples=[0.041])
    max_mm: float | None = Field(examples=[0.093])
    own_mm: float | None = Field(
        None,
        examples=[0.031],
        description="RMS by which they would be missed without it, all other parameters fitted again.",
    )


class FindingDocument(Document):
    """One cause that the data show."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    amplitude: float | None = Field(examples=[0.021])
    unit: str = Field(examples=["deg"])
    amplitude_standard_uncertainty: float | None = Field(examples=[0.003])
    p_value: float | None = Field(description="Corrected for everything that was tried.")
    confidence: Confidence
    details: list[DetailDocument]
    sentence: str
    confusable_with: list[CauseDocument] = Field(description="What these data cannot tell from it.")
    gain: GainDocument | None
    share: float | None = Field(description="Of the structure explained: 0 to 1.")
    parameters: list[str] = Field(description="Their names in the extended model.")
    curve: CurveDocument | None
    where: str = Field("", examples=["joint 3"], description="Empty: it was stored before findings said so.")
    over: str = Field("", examples=["direction"], description="What it depends on.")
    shape: Shape | None = Field(None, examples=["sign"])
    worth: WorthDocument | None = Field(None, description="Null for what is wrong with readings.")
    spectrum: SpectrumDocument | None = Field(None, description="Where it is several waves of a joint.")


class DependenceDocument(Document):
    """Something that what is left depends on."""

    variable: str = Field(examples=["angle of joint 4"])
    p_value: float | None
    curve: CurveDocument | None


class DescribedDocument(Document):
    """A place and a variable without a name, where the model holds a function."""

    where: str = Field(examples=["joint 2"])
    over: str = Field(examples=["angle of joint 1"])
    worth: WorthDocument


class RemainingDocument(Document):
    """What the findings leave, and what of it is described without a name."""

    structure: bool
    depends_on: list[DependenceDocument]
    sentence: str
    described: list[DescribedDocument] = Field([], description="Largest first; it is in the extended model.")
    described_gain: GainDocument | None = Field(
        None, description="What all of it takes off the held-out errors beside the findings."
    )


class NextMeasurementDocument(Document):
    """What would tell causes apart; configurations can be added to a session."""

    sentence: str
    configurations_deg: list[list[float]]
    separates: list[CauseDocument]


class RuledOutDocument(Document):
    """A cause that was looked at and not found, or that these data cannot show."""

    effect: str
    subject: str
    reason: str
    p_value: float | None
    visible: bool = Field(description="False: these data cannot show it.")
    upper_limit_mm: float | None = Field(
        None,
        examples=[0.018],
        description="How large it could still be (95 %), RMS at the tool over the measured configurations. "
        "Null: these data cannot show it.",
    )


class NoiseDocument(Document):
    """What the readings say of their own noise."""

    scale: float | None = Field(description="Scatter left over stated uncertainty.")
    tail_degrees_of_freedom: float | None = Field(description="Of Student's t; null: normal.")
    sentence: str


class WorstDocument(Document):
    """The held-out point at which the extended model is farthest off."""

    config: int = Field(examples=[57])
    before_mm: float | None
    after_mm: float | None


class DiagnosisDocument(Document):
    """What `truepose diagnose --json` prints."""

    robot: str
    verdict: Verdict
    message: str
    start_effects: list[str]
    findings: list[FindingDocument]
    small_findings: list[FindingDocument] = Field(
        [], description="Each takes less than 2 % off the held-out error; in the model as well."
    )
    quantity: str = Field(examples=["position"])
    before: StatisticsDocument | None
    after: StatisticsDocument | None
    held_out: HeldOut
    worst: WorstDocument | None = None
    remaining: RemainingDocument
    next_measurements: list[NextMeasurementDocument]
    ruled_out: list[RuledOutDocument]
    withdrawn: list[str]
    noise: NoiseDocument | None
