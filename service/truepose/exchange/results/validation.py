"""Validations and tests of ISO 9283 as documents: angles in degrees."""

from collections.abc import Iterator
from operator import itemgetter
from typing import Annotated, Literal

from pydantic import AliasChoices, Field

from truepose.domain.validation import DecisionRule, Validation, Verdict
from truepose.exchange.json_text import Json
from truepose.exchange.results.document import (
    UNIT,
    Document,
    FieldSource,
    PairDocument,
    Quantities,
    Quantity,
    Spoken,
    SpokenOutcome,
    StatisticsDocument,
    TurnPairDocument,
    in_file_unit,
)
from truepose.validation.cautions import pose_test_caution
from truepose.validation.iso9283.pose_test import CommandedBy, PoseTest
from truepose.validation.outcome import outcome_of


class HistogramDocument(Document):
    """Counts in bins of equal width."""

    width_mm: Quantity = Field(examples=[0.02])
    from_mm: Quantity = Field(description="Lower edge of the first bin.", examples=[-0.4])
    counts: list[int] = Field(examples=[[3, 41, 38, 2]])


class SignedErrorsDocument(Document):
    """Signed errors (measured minus predicted)."""

    mean_mm: Quantity = Field(description="Mean of the signed errors.", examples=[0.004])
    positive_share: Quantity = Field(examples=[0.52])
    histogram: HistogramDocument


class DistanceErrorsDocument(Document):
    """Signed errors of the distances between all pairs of points."""

    nominal: SignedErrorsDocument
    identified: SignedErrorsDocument


class ZoneDocument(Document):
    """Zone of the readings used to identify the model; if `stated` is false, of the validation readings."""

    x_mm: Annotated[Quantity, FieldSource("zone_centre_mm", itemgetter(0))]
    y_mm: Annotated[Quantity, FieldSource("zone_centre_mm", itemgetter(1))]
    z_mm: Annotated[Quantity, FieldSource("zone_centre_mm", itemgetter(2))]
    radius_mm: Annotated[Quantity, FieldSource("zone_radius_mm")]
    stated: Annotated[bool, FieldSource("zone_stated")]


class _PartDocument(PairDocument):
    """Errors of a subset of the readings."""

    nominal: Annotated[StatisticsDocument, FieldSource("errors.nominal")]
    identified: Annotated[StatisticsDocument, FieldSource("errors.identified")]


class ShellDocument(_PartDocument):
    """Errors of the readings within a range of distances."""

    from_mm: Quantity
    to_mm: Quantity


class BranchDocument(_PartDocument):
    """Errors of the readings in one posture of the arm."""

    branch: str = Field(examples=["front/up/no flip"])


class PlacesDocument(Document):
    """Errors by location; shells and branches without readings are omitted."""

    zone: Annotated[ZoneDocument, FieldSource("")]
    from_zone: list[ShellDocument] = Field(description="Errors by distance from the centre of the zone.")
    from_axis: list[ShellDocument] = Field(description="Errors by distance from the line of axis 1.")
    branches: list[BranchDocument] = Field(
        description="Errors by posture; empty if the arm has no closed-form inverse kinematics, so its "
        "branches have no names."
    )


class DecisionDocument(Document):
    """Conformity decision for the largest error against the limit (ISO 14253-1)."""

    rule: DecisionRule
    limit_mm: Quantity
    error_mm: Quantity
    guard_mm: Quantity = Field(
        description="Guard band of 1.65 standard uncertainties of the measurement; 0 for the simple "
        "decision rule."
    )
    verdict: Verdict


class FigureUncertaintyDocument(Document):
    """Standard uncertainty of the figures of the same names, to first order (GUM)."""

    mean_mm: Quantity = Field(examples=[0.002])
    rms_mm: Quantity = Field(examples=[0.002])
    sd_mm: Quantity = Field(examples=[0.001])
    max_mm: Quantity = Field(examples=[0.008])
    signed_mean_mm: Quantity | None = Field(
        None, description="Standard uncertainty of the signed mean; for distances only."
    )


class UncertaintyPairDocument(Document):
    """Uncertainties for the nominal and the identified model."""

    nominal: FigureUncertaintyDocument
    identified: FigureUncertaintyDocument


class ValidationUncertaintyDocument(Document):
    """Standard uncertainties of the figures of `position`, `relative` and `distance`."""

    position: UncertaintyPairDocument | None
    relative: UncertaintyPairDocument | None
    distance: UncertaintyPairDocument | None


class ValidationDocument(Document):
    """Result of `truepose validate --json`; `distance` is null if there are no pairs."""

    outcome: Annotated[SpokenOutcome, FieldSource("", outcome_of)] = ""
    quantity: Literal["position", "length"]
    position: PairDocument
    relative: PairDocument | None = Field(
        None,
        description="Position errors after the best rigid alignment, so independent of the position of "
        "the base.",
    )
    distance: PairDocument | None
    distance_errors: DistanceErrorsDocument | None = Field(
        None, description="Signed distance errors of all pairs, with histogram; null if there are no pairs."
    )
    places: PlacesDocument | None = Field(
        None, description="Errors by location; null for results stored by earlier versions."
    )
    uncertainty: ValidationUncertaintyDocument | None = Field(
        None, description="Uncertainties of the figures; null for results stored by earlier versions."
    )
    orientation: TurnPairDocument | None = Field(
        None,
        validation_alias=AliasChoices("turns", "orientation"),
        description="Orientation errors; null if no orientations were measured.",
    )
    limit_mm: Quantity
    decision: DecisionDocument | None = Field(
        None, description="Conformity decision; null if no limit was given."
    )
    # `pass` is a word of Python: values have `passed`, documents `pass`, and either is read.
    passed: bool = Field(validation_alias=AliasChoices("passed", "pass"), serialization_alias="pass")


def validation_document(validation: Validation) -> dict[str, Json]:
    """Return what `validate --json` prints."""
    return ValidationDocument.of(validation).printed()


class FigureDocument(Document):
    """A characteristic of ISO 9283:1998; component accuracies are signed, repeatabilities are half widths."""

    symbol: Literal["AP", "RP", "vAP", "AD", "RD", "dAP", "dRP"]
    component: Literal["p", "l", "x", "y", "z", "a", "b", "c"] = Field(
        description="p: position or distance; l: radius about the barycentre; a, b, c: angles about x, y, z."
    )
    subject: str = Field(examples=["P1", "P2-P4"])
    commanded_by: CommandedBy | None = Field(
        description="Model used to compute the commanded pose; null if the characteristic does not depend "
        "on it."
    )
    value: Annotated[Quantity, in_file_unit("value")]
    standard_uncertainty: Annotated[Quantity, in_file_unit("standard_uncertainty")]
    unit: Annotated[str, UNIT] = Field(examples=["mm", "deg"])
    visits: int
    noise: Annotated[Quantity, in_file_unit("noise")] = Field(
        description="Value expected from the stated instrument noise alone."
    )
    clause: str = Field(examples=["7.2.1"])


class WithheldDocument(Document):
    """A characteristic that cannot be computed from these measurements, with the reason."""

    symbol: str
    subject: str
    reason: Spoken


class CommandedPoseDocument(Document):
    """A commanded pose, in the frame of the readings."""

    name: str = Field(examples=["P1"])
    position_mm: Quantities


class DriftPointDocument(Document):
    """One group of a drift test; uncertainties include scatter only."""

    hours: Quantity = Field(description="Time since the first group.")
    visits: int
    accuracy_mm: Quantity = Field(description="AP with respect to the identified model.")
    accuracy_uncertainty_mm: Quantity
    repeatability_mm: Quantity
    repeatability_uncertainty_mm: Quantity
    moved_mm: Quantity = Field(description="Displacement of the barycentre since the first group.")
    moved_uncertainty_mm: Quantity


class DriftDocument(Document):
    """Changes over the duration of the drift test."""

    hours: Quantity
    settled: bool = Field(
        description="True if the rate of change in the last hour is below a tenth of that in the first hour."
    )
    walk_mm: Quantity | None = Field(description="Largest displacement of the barycentre; null if withheld.")
    curve: list[DriftPointDocument]


class PoseTestDocument(Document):
    """Result of `truepose validate --iso9283 --json`, under the key `iso9283`."""

    poses: int
    cycles: int
    nest: int = Field(description="Tool nest whose positions were evaluated.")
    commanded: list[CommandedPoseDocument] = Field(
        description="Commanded poses according to the identified model."
    )
    figures: Annotated[list[FigureDocument], FieldSource("", lambda test: list(_figures(test)))]
    withheld: Annotated[list[WithheldDocument], FieldSource("identified.withheld")]
    work_space: PairDocument | None = Field(
        description="Errors at configurations that are not test poses; null if none were measured."
    )
    claimed_mm: Quantity = Field(description="Mean error predicted by the model for such configurations.")
    sentence: Annotated[Spoken, FieldSource("", pose_test_caution)]
    drift: DriftDocument | None = Field(description="Results by group; null if the test is not a drift test.")


class AccuracyDocument(ValidationDocument):
    """A validation, including ISO 9283 characteristics if its readings are from such a test."""

    iso9283: PoseTestDocument | None = None


def accuracy_document(validation: Validation, test: PoseTest | None) -> AccuracyDocument:
    """Return both as one document."""
    return AccuracyDocument.of(validation, iso9283=test, outcome=outcome_of(validation))


def pose_test_document(test: PoseTest) -> dict[str, Json]:
    """Return the figures of a test, what is withheld, and what the test does not prove."""
    return PoseTestDocument.of(test).printed()


def _figures(test: PoseTest) -> Iterator[FigureDocument]:
    for commanded_by, figure in test.figures():
        yield FigureDocument.of(figure, commanded_by=commanded_by)
