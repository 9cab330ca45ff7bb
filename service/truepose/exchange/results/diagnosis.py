"""A diagnosis as a document: what `diagnose --json` prints and the REST API shows.

Amplitudes, details and curves already state the unit that they are in; nothing is converted here.
"""

from typing import Annotated

from pydantic import AliasChoices, BeforeValidator, Field

from truepose.domain.diagnosis import Confidence, Diagnosis, HeldOut, HeldOutErrors, Shape, Verdict
from truepose.exchange.json_text import Json
from truepose.exchange.results.document import (
    Document,
    FieldSource,
    Quantities,
    Quantity,
    Spoken,
    SpokenOutcome,
    StatisticsDocument,
)
from truepose.validation.outcome import outcome_of


class CauseDocument(Document):
    """A cause by its name."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])


class DetailDocument(Document):
    """One more number of a finding, in the unit that it names."""

    name: str = Field(examples=["order"])
    value: Quantity = Field(examples=[2.0])
    unit: str = Field(examples=["1"])
    standard_uncertainty: Quantity = Field(examples=[0.0])


class GainDocument(Document):
    """What the finding takes off the held-out errors."""

    rms_before_mm: Quantity = Field(examples=[0.061])
    rms_after_mm: Quantity = Field(examples=[0.019])
    interval_95_mm: Quantities = Field(
        min_length=2, max_length=2, description="Of the difference, before less after."
    )


class CurvePointsDocument(Document):
    """Further readings of a curve, as its own are."""

    x: Quantities
    residual: Quantities
    standard_uncertainty: Quantities


class CurveDocument(Document):
    """Residuals along one variable, with what was fitted to them; units stand beside."""

    variable: str = Field(examples=["angle of joint 4"])
    variable_unit: str = Field(examples=["deg"])
    quantity: str = Field(examples=["error of joint 4"])
    quantity_unit: str = Field(examples=["deg"])
    x: Quantities
    residual: Quantities
    standard_uncertainty: Quantities
    line_x: Quantities
    line: Quantities
    line_band: Quantities = Field(description="Half width of the 95 % band.")
    unseen: CurvePointsDocument | None = Field(
        None, description="Validation readings, which were never fitted; null where there are none to draw."
    )


class SpectrumDocument(Document):
    """Waves of one joint by their order."""

    order: Quantities = Field(description="Periods per turn, ascending.", examples=[[1.0, 2.0]])
    amplitude_deg: Quantities = Field(examples=[[0.021, 0.008]])
    standard_uncertainty_deg: Quantities = Field(examples=[[0.002, 0.002]])


class WorthDocument(Document):
    """How far a cause moves the tool over the calibration readings."""

    mean_mm: Quantity = Field(examples=[0.041])
    max_mm: Quantity = Field(examples=[0.093])
    own_mm: Quantity = Field(
        None,
        examples=[0.031],
        description="RMS by which they would be missed without it, all other parameters fitted again.",
    )


class FindingDocument(Document):
    """One cause that the data show."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    amplitude: Quantity = Field(examples=[0.021])
    unit: str = Field(examples=["deg"])
    amplitude_standard_uncertainty: Quantity = Field(examples=[0.003])
    p_value: Quantity = Field(description="Corrected for everything that was tried.")
    confidence: Confidence
    details: list[DetailDocument]
    sentence: Spoken
    confusable_with: list[CauseDocument] = Field(description="What these data cannot tell from it.")
    gain: GainDocument | None
    share: Quantity = Field(description="Of the structure explained: 0 to 1.")
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
    p_value: Quantity
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
    sentence: Spoken
    described: list[DescribedDocument] = Field([], description="Largest first; it is in the extended model.")
    described_gain: GainDocument | None = Field(
        None, description="What all of it takes off the held-out errors beside the findings."
    )


class NextMeasurementDocument(Document):
    """What would tell causes apart; configurations can be added to a session."""

    sentence: Spoken
    configurations_deg: list[list[float]]
    separates: list[CauseDocument]


class RuledOutDocument(Document):
    """A cause that was looked at and not found, or that these data cannot show."""

    effect: str
    subject: str
    reason: Spoken
    p_value: Quantity
    visible: bool = Field(description="False: these data cannot show it.")
    upper_limit_mm: Quantity = Field(
        None,
        examples=[0.018],
        description="How large it could still be (95 %), RMS at the tool over the measured configurations. "
        "Null: these data cannot show it.",
    )


class NoiseDocument(Document):
    """What the readings say of their own noise."""

    scale: Quantity = Field(description="Scatter left over stated uncertainty.")
    tail_degrees_of_freedom: Quantity = Field(description="Of Student's t; null: normal.")
    sentence: Spoken


class WorstDocument(Document):
    """The held-out point at which the extended model is farthest off."""

    config: int = Field(examples=[57])
    before_mm: Quantity
    after_mm: Quantity


def _worst(found: object) -> object:
    """Return the worst of held-out errors; None where nothing was fitted."""
    if not isinstance(found, HeldOutErrors):
        return found
    return found.worst if len(found.config) else None


class DiagnosisDocument(Document):
    """What `truepose diagnose --json` prints."""

    robot: str
    verdict: Verdict
    outcome: Annotated[SpokenOutcome, FieldSource("", outcome_of)] = ""
    message: Spoken
    start_effects: list[str]
    findings: list[FindingDocument]
    small_findings: list[FindingDocument] = Field(
        [],
        validation_alias=AliasChoices("small_findings", "small"),
        description="Each takes less than 2 % off the held-out error; in the model as well.",
    )
    quantity: str = Field(examples=["position"])
    nominal: StatisticsDocument | None = Field(None, description="Of the robot as its maker describes it.")
    before: StatisticsDocument | None
    after: StatisticsDocument | None
    held_out: HeldOut
    worst: Annotated[WorstDocument | None, BeforeValidator(_worst)] = Field(
        None, validation_alias=AliasChoices("worst", "errors")
    )
    remaining: RemainingDocument
    next_measurements: list[NextMeasurementDocument]
    ruled_out: list[RuledOutDocument]
    withdrawn: list[Spoken]
    noise: NoiseDocument | None


def diagnosis_document(diagnosis: Diagnosis) -> dict[str, Json]:
    """Return what `diagnose --json` prints, whatever the verdict.

    `before` and `after` are null where nothing could be fitted, `gain` where nothing held out shows it,
    `curve` where there is nothing to draw, `described_gain` where nothing is described.
    """
    return DiagnosisDocument.of(diagnosis).printed()
