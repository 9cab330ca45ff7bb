"""A test of ISO 9283 as a document: angles in degrees."""

from collections.abc import Iterator
from typing import Literal, Self

from pydantic import Field

from truepose.domain.results.validation import Validation
from truepose.exchange.json_text import Json
from truepose.exchange.models.document import file_factor, file_unit
from truepose.exchange.outgoing import Quantities, Quantity
from truepose.exchange.results.document_base import Document, Spoken
from truepose.exchange.results.statistics import PairDocument
from truepose.exchange.results.validation import ValidationDocument
from truepose.judgement.cautions import pose_test_caution
from truepose.judgement.iso9283.characteristics import Characteristic
from truepose.judgement.iso9283.drift import Drift
from truepose.judgement.iso9283.judged import CommandedBy, PoseTest


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
    value: Quantity
    standard_uncertainty: Quantity
    unit: str = Field(examples=["mm", "deg"])
    visits: int
    noise: Quantity = Field(description="What the instrument's stated scatter alone would show.")
    clause: str = Field(examples=["7.2.1"])

    @classmethod
    def of_figure(cls, figure: Characteristic, commanded_by: CommandedBy | None) -> Self:
        """Return a figure in the units of files."""
        factor = file_factor(figure.unit)
        return cls.of(
            figure,
            commanded_by=commanded_by,
            value=figure.value * factor,
            standard_uncertainty=figure.standard_uncertainty * factor,
            noise=figure.noise * factor,
            unit=file_unit(figure.unit),
        )


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

    @classmethod
    def of_drift(cls, drift: Drift) -> Self:
        """Return the curve of a test."""
        return cls.of(drift, curve=[DriftPointDocument.of(point) for point in drift.curve])


class PoseTestDocument(Document):
    """What `truepose validate --iso9283 --json` adds under `iso9283`."""

    poses: int
    cycles: int
    nest: int = Field(description="Whose positions were taken.")
    commanded: list[CommandedPoseDocument] = Field(description="As the identified model puts them.")
    figures: list[FigureDocument]
    withheld: list[WithheldDocument]
    work_space: PairDocument | None = Field(
        description="Errors at configurations that are no poses; null where none was measured."
    )
    claimed_mm: Quantity = Field(description="Mean error that the model itself lets expect of such.")
    sentence: Spoken
    drift: DriftDocument | None = Field(description="Group by group; null where the test is another one.")

    @classmethod
    def of_test(cls, test: PoseTest) -> Self:
        """Return the document of a test."""
        return cls.of(
            test,
            figures=list(_figures(test)),
            withheld=test.identified.withheld,
            sentence=pose_test_caution(test),
            drift=None if test.drift is None else DriftDocument.of_drift(test.drift),
        )


class AccuracyDocument(ValidationDocument):
    """A validation, with the figures of ISO 9283 where its readings are visits of such a test."""

    iso9283: PoseTestDocument | None = None


def accuracy_document(validation: Validation, test: PoseTest | None) -> AccuracyDocument:
    """Return both as one document."""
    found = None if test is None else PoseTestDocument.of_test(test)
    return AccuracyDocument.of(validation, iso9283=found)


def pose_test_document(test: PoseTest) -> dict[str, Json]:
    """Return the figures of a test, what is withheld, and what the test does not prove."""
    return PoseTestDocument.of_test(test).printed()


def _figures(test: PoseTest) -> Iterator[FigureDocument]:
    for commanded_by, figure in test.figures():
        yield FigureDocument.of_figure(figure, commanded_by)
