"""What a table of corrected targets came to, and what a proof move says, as documents."""

import math
from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import Annotated

from pydantic import Field

from truepose.correction.proof import Proof
from truepose.domain.correction import CorrectionTotals, UncorrectedTarget
from truepose.exchange.json_text import Json
from truepose.exchange.results.document import (
    Document,
    FieldSource,
    Integers,
    Quantity,
    Rows,
    Spoken,
    SpokenOutcome,
    StatisticsDocument,
    in_degrees,
)
from truepose.validation.outcome import Outcome


class FailedTarget(Document):
    """A target that was not corrected, with the reason."""

    target: Annotated[str, FieldSource("", itemgetter(0))]
    status: Annotated[str, FieldSource("", itemgetter(1))] = Field(examples=["out_of_reach"])


class LeftAloneDocument(Document):
    """A statement of the program that was not corrected, with the reason."""

    line: int
    what: str = Field(examples=["MoveL Offs(p10,0,0,50)"])
    reason: Spoken
    file: str | None = Field(description="Name of the file; null for the main program.")


def _where_known(name: str, convert: Callable[[float], float]) -> FieldSource:
    """Return what is known of a measured zone where there is one."""
    return FieldSource("", lambda totals: convert(getattr(totals, name)) if totals.zone_known else None)


class CorrectionDocument(Document):
    """Summary of the corrected targets; errors are those of the model, uncertainties those of the robot."""

    targets: int
    corrected: Annotated[int, FieldSource("solved")]
    statuses: dict[str, int] = Field(examples=[{"ok": 998, "out_of_reach": 2}])
    not_corrected: Annotated[list[FailedTarget], FieldSource("failed")] = Field(
        description="Targets that were not corrected; the first 100 at most."
    )
    largest_error_mm: Quantity
    mean_u_mm: Annotated[Quantity, FieldSource("mean_uncertainty_mm")] = Field(
        description="Mean standard uncertainty per axis."
    )
    largest_u_mm: Annotated[Quantity, FieldSource("largest_uncertainty_mm")]
    far_moved: int = Field(
        description="Number of corrected targets for which a joint differs by more than 5 deg from the "
        "controller's solution."
    )
    largest_move_deg: Annotated[Quantity, in_degrees("largest_move_rad")] = Field(
        description="Largest joint difference from the controller's own solution."
    )
    outside: Annotated[int | None, _where_known("outside", int)] = Field(
        description="Number of corrected targets outside the measured zone; null if the zone is unknown."
    )
    farthest_outside_mm: Annotated[Quantity, _where_known("farthest_outside_mm", float)] = Field(
        description="Farthest distance of the flange frame outside the measured zone."
    )
    farthest_outside_deg: Annotated[Quantity, _where_known("farthest_outside_rad", math.degrees)] = Field(
        description="Farthest joint angle outside the measured zone."
    )
    left_alone: list[LeftAloneDocument] = Field(
        description="Statements that move the robot but cannot be corrected by changing numbers."
    )


def correction_document(
    totals: CorrectionTotals, left_alone: Sequence[UncorrectedTarget] = ()
) -> dict[str, Json]:
    """Return what `truepose correct --json` prints."""
    return correction_of(totals, left_alone).printed()


def correction_of(
    totals: CorrectionTotals, left_alone: Sequence[UncorrectedTarget] = ()
) -> CorrectionDocument:
    """Return the document of a correction."""
    return CorrectionDocument.of(totals, left_alone=list(left_alone))


class ProofErrorsDocument(Document):
    """Deviation of each measured nest position from its target; x, y, z in the world frame."""

    config: Integers = Field(description="Number of the uncorrected configuration.")
    nest: Integers
    target_mm: Rows
    before_mm: Rows
    after_mm: Rows


class ProofDocument(Document):
    """Comparison of the same targets measured without and with correction."""

    outcome: Annotated[
        SpokenOutcome, FieldSource("", lambda proof: Outcome(proof.before, proof.after).sentence)
    ] = ""
    targets: Annotated[int, FieldSource("before.n")] = Field(examples=[30])
    before: StatisticsDocument = Field(
        description="Errors without correction: measured nest position against target."
    )
    after: StatisticsDocument = Field(
        description="Errors with correction: measured nest position against target."
    )
    before_relative: StatisticsDocument | None = Field(
        description="Errors after the best rigid alignment; null for fewer than four targets or targets on "
        "a line."
    )
    after_relative: StatisticsDocument | None
    gain: Quantity = Field(
        description="Ratio of the mean error without correction to the mean error with correction.",
        examples=[12.4],
    )
    gain_interval_95: list[Quantity] = Field(min_length=2, max_length=2, examples=[[10.1, 15.2]])
    promised_mean_mm: Annotated[Quantity, FieldSource("promised_mm")] = Field(
        description="Mean error predicted from the uncertainty of model, arm and readings."
    )
    keeps_promise: bool
    proved: bool = Field(
        description="True if the correction is a significant improvement and achieves the predicted accuracy."
    )
    foretold_share: Quantity = Field(
        description="Share of the errors predicted by the model that was present without correction; 1 "
        "means all of it.",
        examples=[0.98],
    )
    cautions: list[Spoken] = Field(description="Possible reasons why the correction does not help.")
    errors: ProofErrorsDocument


def proof_document(proof: Proof) -> ProofDocument:
    """Return the document of a proof."""
    return ProofDocument.of(proof)
