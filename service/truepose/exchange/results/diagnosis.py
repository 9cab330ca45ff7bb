"""A diagnosis as a document: what `diagnose --json` prints and the REST API shows.

Amplitudes, details and curves already state the unit that they are in; nothing is converted here.
"""

from typing import Annotated

from pydantic import AliasChoices, BeforeValidator, Field

from truepose.domain.diagnosis import (
    Confidence,
    Diagnosis,
    HeldOut,
    HeldOutErrors,
    ScatterVariable,
    Shape,
    Verdict,
)
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
from truepose.exchange.results.set_aside import SetAside
from truepose.validation.outcome import outcome_of


class CauseDocument(Document):
    """An error source, by effect and subject."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])


class DetailDocument(Document):
    """A further quantity of a finding, with its unit."""

    name: str = Field(examples=["order"])
    value: Quantity = Field(examples=[2.0])
    unit: str = Field(examples=["1"])
    standard_uncertainty: Quantity = Field(examples=[0.0])


class GainDocument(Document):
    """Reduction of the held-out errors by the finding."""

    rms_before_mm: Quantity = Field(examples=[0.061])
    rms_after_mm: Quantity = Field(examples=[0.019])
    interval_95_mm: Quantities = Field(
        min_length=2,
        max_length=2,
        description="95 % confidence interval of the reduction (before minus after).",
    )


class CurvePointsDocument(Document):
    """Additional readings of a curve, in the units of the curve."""

    x: Quantities
    residual: Quantities
    standard_uncertainty: Quantities


class CurveDocument(Document):
    """Residuals plotted over one variable, with the fitted curve and the units of both."""

    variable: str = Field(examples=["angle of joint 4"])
    variable_unit: str = Field(examples=["deg"])
    quantity: str = Field(examples=["error of joint 4"])
    quantity_unit: str = Field(examples=["deg"])
    x: Quantities
    residual: Quantities
    standard_uncertainty: Quantities
    line_x: Quantities
    line: Quantities
    line_band: Quantities = Field(description="Half width of the 95 % confidence band.")
    unseen: CurvePointsDocument | None = Field(
        None, description="Validation readings, which were not used in the fit; null if there are none."
    )


class SpectrumDocument(Document):
    """Harmonics of one joint by order."""

    order: Quantities = Field(description="Periods per turn, in ascending order.", examples=[[1.0, 2.0]])
    amplitude_deg: Quantities = Field(examples=[[0.021, 0.008]])
    standard_uncertainty_deg: Quantities = Field(examples=[[0.002, 0.002]])


class WorthDocument(Document):
    """Effect size: displacement of the tool over the calibration readings caused by an error source."""

    mean_mm: Quantity = Field(examples=[0.041])
    max_mm: Quantity = Field(examples=[0.093])
    own_mm: Quantity = Field(
        None,
        examples=[0.031],
        description="RMS error of the calibration readings without this cause, after refitting all other "
        "parameters.",
    )


class FindingDocument(Document):
    """An error source found in the data."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    amplitude: Quantity = Field(examples=[0.021])
    unit: str = Field(examples=["deg"])
    amplitude_standard_uncertainty: Quantity = Field(examples=[0.003])
    p_value: Quantity = Field(description="p-value, corrected for all hypotheses tested.")
    confidence: Confidence
    details: list[DetailDocument]
    sentence: Spoken
    confusable_with: list[CauseDocument] = Field(
        description="Alternative causes that these data cannot distinguish from this cause."
    )
    gain: GainDocument | None
    share: Quantity = Field(description="Share of the systematic error explained by this finding, 0 to 1.")
    parameters: list[str] = Field(
        description="Names of the parameters of this finding in the extended model."
    )
    curve: CurveDocument | None
    where: str = Field(
        "",
        examples=["joint 3"],
        description="Location of the error source; empty for results stored by earlier versions.",
    )
    over: str = Field("", examples=["direction"], description="Variable on which the error depends.")
    shape: Shape | None = Field(None, examples=["sign"])
    worth: WorthDocument | None = Field(
        None, description="Effect size; null if the cause lies in the readings."
    )
    spectrum: SpectrumDocument | None = Field(
        None, description="Amplitudes by order; null unless the finding consists of several joint harmonics."
    )


class DependenceDocument(Document):
    """A variable on which the residuals still depend."""

    variable: str = Field(examples=["angle of joint 4"])
    p_value: Quantity
    curve: CurveDocument | None


class DescribedDocument(Document):
    """A residual error modelled by an empirical function, without a named cause."""

    where: str = Field(examples=["joint 2"])
    over: str = Field(examples=["angle of joint 1"])
    worth: WorthDocument


class RemainingDocument(Document):
    """The residual errors after all findings, and the part modelled without a named cause."""

    structure: bool
    depends_on: list[DependenceDocument]
    sentence: Spoken
    described: list[DescribedDocument] = Field(
        [], description="Empirical functions in the extended model, largest first."
    )
    described_gain: GainDocument | None = Field(
        None, description="Further reduction of the held-out errors by these functions."
    )


class NextMeasurementDocument(Document):
    """A measurement that would separate alternative causes; its configurations can be added to a session."""

    sentence: Spoken
    configurations_deg: list[list[float]]
    separates: list[CauseDocument]


class RuledOutDocument(Document):
    """A cause that was tested and not found, or that cannot be seen in these data."""

    effect: str
    subject: str
    reason: Spoken
    p_value: Quantity
    visible: bool = Field(description="False if these data cannot show the cause.")
    upper_limit_mm: Quantity = Field(
        None,
        examples=[0.018],
        description="Upper 95 % limit of the effect: RMS at the tool over the measured configurations. "
        "Null if these data cannot show the cause.",
    )


class ScatterDocument(Document):
    """Noise that is larger at some readings than at others."""

    variable: ScatterVariable = Field(
        description="reach: distance from the base; range: distance from the instrument; angle: of the joint "
        "in `subject`; time: after the first reading; nest, mounting and placement are numbers."
    )
    subject: str = Field(examples=["joint 3"], description="Empty unless the variable is an angle.")
    unit: str = Field(examples=["mm"], description="Unit of the variable; empty for numbers.")
    at_low: Quantity = Field(description="Where the scatter is smallest.")
    low_mm: Quantity = Field(description="Standard deviation per axis there.")
    at_high: Quantity = Field(description="Where the scatter is largest.")
    high_mm: Quantity = Field(description="Standard deviation per axis there.")
    p_value: Quantity


class NoiseDocument(Document):
    """Noise of the readings, estimated from the data."""

    scale: Quantity = Field(description="Ratio of the remaining scatter to the stated uncertainty.")
    tail_degrees_of_freedom: Quantity = Field(
        description="Degrees of freedom of Student's t; null for a normal distribution."
    )
    sentence: Spoken
    scatter: ScatterDocument | None = Field(
        None, description="On what the size of the noise depends; null if it is the same everywhere."
    )


class WorstDocument(Document):
    """The held-out point with the largest error of the extended model."""

    config: int = Field(examples=[57])
    before_mm: Quantity
    after_mm: Quantity


def _worst(found: object) -> object:
    """Return the worst of held-out errors; None where nothing was fitted."""
    if not isinstance(found, HeldOutErrors):
        return found
    return found.worst if len(found.config) else None


class DiagnosisDocument(Document):
    """Result of `truepose diagnose --json`."""

    robot: str
    verdict: Verdict
    outcome: Annotated[SpokenOutcome, FieldSource("", outcome_of)] = ""
    message: Spoken
    start_effects: list[str]
    findings: list[FindingDocument]
    small_findings: list[FindingDocument] = Field(
        [],
        validation_alias=AliasChoices("small_findings", "small"),
        description="Findings that each reduce the held-out error by less than 2 %; included in the model.",
    )
    quantity: str = Field(examples=["position"])
    nominal: StatisticsDocument | None = Field(
        None, description="Errors of the nominal robot, as specified by the manufacturer."
    )
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
    set_aside: SetAside = None
    named_share: Quantity = Field(
        None,
        examples=[0.91],
        description="Share of the squared held-out error beyond the noise that the findings take off.",
    )


def diagnosis_document(diagnosis: Diagnosis) -> dict[str, Json]:
    """Return what `diagnose --json` prints, whatever the verdict.

    `before` and `after` are null where nothing could be fitted, `gain` where nothing held out shows it,
    `curve` where there is nothing to draw, `described_gain` where nothing is described.
    """
    return DiagnosisDocument.of(diagnosis).printed()
