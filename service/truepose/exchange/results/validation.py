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
    """Counts in bins of one width."""

    width_mm: Quantity = Field(examples=[0.02])
    from_mm: Quantity = Field(description="Where the first bin begins.", examples=[-0.4])
    counts: list[int] = Field(examples=[[3, 41, 38, 2]])


class SignedErrorsDocument(Document):
    """What the signs of errors tell, seen minus predicted."""

    mean_mm: Quantity = Field(description="With sign.", examples=[0.004])
    positive_share: Quantity = Field(examples=[0.52])
    histogram: HistogramDocument


class DistanceErrorsDocument(Document):
    """Errors of the distances between all pairs of points, with their signs."""

    nominal: SignedErrorsDocument
    identified: SignedErrorsDocument


class ZoneDocument(Document):
    """Where the readings lay that made the model; not `stated`: that judge it."""

    x_mm: Annotated[Quantity, FieldSource("zone_centre_mm", itemgetter(0))]
    y_mm: Annotated[Quantity, FieldSource("zone_centre_mm", itemgetter(1))]
    z_mm: Annotated[Quantity, FieldSource("zone_centre_mm", itemgetter(2))]
    radius_mm: Annotated[Quantity, FieldSource("zone_radius_mm")]
    stated: Annotated[bool, FieldSource("zone_stated")]


class _PartDocument(PairDocument):
    """Errors of some of the readings."""

    nominal: Annotated[StatisticsDocument, FieldSource("errors.nominal")]
    identified: Annotated[StatisticsDocument, FieldSource("errors.identified")]


class ShellDocument(_PartDocument):
    """Errors of the readings at some distance from something."""

    from_mm: Quantity
    to_mm: Quantity


class BranchDocument(_PartDocument):
    """Errors of the readings in one posture of the arm."""

    branch: str = Field(examples=["front/up/no flip"])


class PlacesDocument(Document):
    """Where errors are large; shells and branches without a reading are left out."""

    zone: Annotated[ZoneDocument, FieldSource("")]
    from_zone: list[ShellDocument] = Field(description="By distance from the middle of the zone.")
    from_axis: list[ShellDocument] = Field(description="By distance from the line of axis 1.")
    branches: list[BranchDocument] = Field(
        description="Empty where the arm has no closed inverse: its branches have no names then."
    )


class DecisionDocument(Document):
    """Whether the largest error stays within the limit (ISO 14253-1), and the reading that decides it."""

    rule: DecisionRule
    limit_mm: Quantity
    error_mm: Quantity
    guard_mm: Quantity = Field(description="1.65 standard uncertainties of measuring it; 0 by simple rule.")
    verdict: Verdict


class FigureUncertaintyDocument(Document):
    """Standard uncertainty of each figure of that name, to first order (GUM)."""

    mean_mm: Quantity = Field(examples=[0.002])
    rms_mm: Quantity = Field(examples=[0.002])
    sd_mm: Quantity = Field(examples=[0.001])
    max_mm: Quantity = Field(examples=[0.008])
    signed_mean_mm: Quantity | None = Field(None, description="Of distances: of the mean with sign.")


class UncertaintyPairDocument(Document):
    """The same for the nominal model and the identified one."""

    nominal: FigureUncertaintyDocument
    identified: FigureUncertaintyDocument


class ValidationUncertaintyDocument(Document):
    """How well the figures of `position`, `relative` and `distance` are known."""

    position: UncertaintyPairDocument | None
    relative: UncertaintyPairDocument | None
    distance: UncertaintyPairDocument | None


class ValidationDocument(Document):
    """What `truepose validate --json` prints; `distance` is null where there are no pairs."""

    outcome: Annotated[SpokenOutcome, FieldSource("", outcome_of)] = ""
    quantity: Literal["position", "length"]
    position: PairDocument
    relative: PairDocument | None = Field(
        None, description="Positions after the best rigid alignment: the base may stand anywhere."
    )
    distance: PairDocument | None
    distance_errors: DistanceErrorsDocument | None = Field(
        None, description="All pairs, with sign and histogram; null where there are no pairs."
    )
    places: PlacesDocument | None = Field(None, description="Null: of a program that did not tell it yet.")
    uncertainty: ValidationUncertaintyDocument | None = Field(
        None, description="Null: of a program that did not tell it yet."
    )
    orientation: TurnPairDocument | None = Field(
        None, validation_alias=AliasChoices("turns", "orientation"), description="Null: none were read."
    )
    limit_mm: Quantity
    decision: DecisionDocument | None = Field(None, description="Null without a limit.")
    # `pass` is a word of Python: values have `passed`, documents `pass`, and either is read.
    passed: bool = Field(validation_alias=AliasChoices("passed", "pass"), serialization_alias="pass")


def validation_document(validation: Validation) -> dict[str, Json]:
    """Return what `validate --json` prints."""
    return ValidationDocument.of(validation).printed()


class FigureDocument(Document):
    """A figure of ISO 9283:1998; accuracies of components have a sign, repeatabilities are half widths."""

    symbol: Literal["AP", "RP", "vAP", "AD", "RD", "dAP", "dRP"]
    component: Literal["p", "l", "x", "y", "z", "a", "b", "c"] = Field(
        description="p: position or distance, l: radius about the barycentre, a b c: angles about x y z."
    )
    subject: str = Field(examples=["P1", "P2-P4"])
    commanded_by: CommandedBy | None = Field(
        description="The model that puts the commanded pose; null where the figure does not depend on it."
    )
    value: Annotated[Quantity, in_file_unit("value")]
    standard_uncertainty: Annotated[Quantity, in_file_unit("standard_uncertainty")]
    unit: Annotated[str, UNIT] = Field(examples=["mm", "deg"])
    visits: int
    noise: Annotated[Quantity, in_file_unit("noise")] = Field(
        description="What the instrument's stated scatter alone would show."
    )
    clause: str = Field(examples=["7.2.1"])


class WithheldDocument(Document):
    """A figure that the visits do not give, and why."""

    symbol: str
    subject: str
    reason: Spoken


class CommandedPoseDocument(Document):
    """A pose, in the frame of the readings."""

    name: str = Field(examples=["P1"])
    position_mm: Quantities


class DriftPointDocument(Document):
    """One group of a test of drift; uncertainties are of scatter alone."""

    hours: Quantity = Field(description="After the first group.")
    visits: int
    accuracy_mm: Quantity = Field(description="AP of the identified model.")
    accuracy_uncertainty_mm: Quantity
    repeatability_mm: Quantity
    repeatability_uncertainty_mm: Quantity
    moved_mm: Quantity = Field(description="Way of the barycentre from that of the first group.")
    moved_uncertainty_mm: Quantity


class DriftDocument(Document):
    """What changed over the hours."""

    hours: Quantity
    settled: bool = Field(description="The rate of change of the last hour is below a tenth of the first.")
    walk_mm: Quantity | None = Field(description="Largest way of the barycentre; null where withheld.")
    curve: list[DriftPointDocument]


class PoseTestDocument(Document):
    """What `truepose validate --iso9283 --json` adds under `iso9283`."""

    poses: int
    cycles: int
    nest: int = Field(description="Whose positions were taken.")
    commanded: list[CommandedPoseDocument] = Field(description="As the identified model puts them.")
    figures: Annotated[list[FigureDocument], FieldSource("", lambda test: list(_figures(test)))]
    withheld: Annotated[list[WithheldDocument], FieldSource("identified.withheld")]
    work_space: PairDocument | None = Field(
        description="Errors at configurations that are no poses; null where none was measured."
    )
    claimed_mm: Quantity = Field(description="Mean error that the model itself lets expect of such.")
    sentence: Annotated[Spoken, FieldSource("", pose_test_caution)]
    drift: DriftDocument | None = Field(description="Group by group; null where the test is another one.")


class AccuracyDocument(ValidationDocument):
    """A validation, with the figures of ISO 9283 where its readings are visits of such a test."""

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
