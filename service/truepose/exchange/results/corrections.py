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
    """A target that was not corrected, and why."""

    target: Annotated[str, FieldSource("", itemgetter(0))]
    status: Annotated[str, FieldSource("", itemgetter(1))] = Field(examples=["out_of_reach"])


class LeftAloneDocument(Document):
    """A place of a program, and why its numbers are as they were."""

    line: int
    what: str = Field(examples=["MoveL Offs(p10,0,0,50)"])
    reason: Spoken
    file: str | None = Field(description="Null: of the program itself.")


def _where_known(name: str, convert: Callable[[float], float]) -> FieldSource:
    """Return what is known of a measured zone where there is one."""
    return FieldSource("", lambda totals: convert(getattr(totals, name)) if totals.zone_known else None)


class CorrectionDocument(Document):
    """Counts and extremes of a table of targets; errors are the model's, uncertainties those of the robot."""

    targets: int
    corrected: Annotated[int, FieldSource("solved")]
    statuses: dict[str, int] = Field(examples=[{"ok": 998, "out_of_reach": 2}])
    not_corrected: Annotated[list[FailedTarget], FieldSource("failed")] = Field(
        description="The first hundred."
    )
    largest_error_mm: Quantity
    mean_u_mm: Annotated[Quantity, FieldSource("mean_uncertainty_mm")] = Field(
        description="Standard, per axis."
    )
    largest_u_mm: Annotated[Quantity, FieldSource("largest_uncertainty_mm")]
    far_moved: int = Field(description="Corrected ones at which a joint turns by more than 5 deg.")
    largest_move_deg: Annotated[Quantity, in_degrees("largest_move_rad")] = Field(
        description="Of a joint, from the controller's own answer."
    )
    outside: Annotated[int | None, _where_known("outside", int)] = Field(
        description="Corrected ones outside the measured zone; null: it is unknown."
    )
    farthest_outside_mm: Annotated[Quantity, _where_known("farthest_outside_mm", float)] = Field(
        description="Of the last frame."
    )
    farthest_outside_deg: Annotated[Quantity, _where_known("farthest_outside_rad", math.degrees)] = Field(
        description="Of a joint."
    )
    left_alone: list[LeftAloneDocument] = Field(
        description="What moves the robot of a program and is not corrected by changing numbers."
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
    """From each target to where its nest was read, target by target; x y z in the world."""

    config: Integers = Field(description="Of the uncorrected stop.")
    nest: Integers
    target_mm: Rows
    before_mm: Rows
    after_mm: Rows


class ProofDocument(Document):
    """The same targets without and with correction, as they were measured."""

    outcome: Annotated[
        SpokenOutcome, FieldSource("", lambda proof: Outcome(proof.before, proof.after).sentence)
    ] = ""
    targets: Annotated[int, FieldSource("before.n")] = Field(examples=[30])
    before: StatisticsDocument = Field(
        description="Without correction: from the target to where the nest was read."
    )
    after: StatisticsDocument = Field(description="With correction.")
    before_relative: StatisticsDocument | None = Field(
        description="After the best rigid alignment of the targets; null of fewer than four, or on a line."
    )
    after_relative: StatisticsDocument | None
    gain: Quantity = Field(description="Mean error without over mean error with correction.", examples=[12.4])
    gain_interval_95: list[Quantity] = Field(min_length=2, max_length=2, examples=[[10.1, 15.2]])
    promised_mean_mm: Annotated[Quantity, FieldSource("promised_mm")] = Field(
        description="Mean error that model, arm and readings let expect."
    )
    keeps_promise: bool
    proved: bool = Field(description="The correction helps beyond chance and keeps its promise.")
    foretold_share: Quantity = Field(
        description="How much of the errors that the model foretells was there without correction; 1: all.",
        examples=[0.98],
    )
    cautions: list[Spoken] = Field(description="What explains a correction that does not help.")
    errors: ProofErrorsDocument


def proof_document(proof: Proof) -> ProofDocument:
    """Return the document of a proof."""
    return ProofDocument.of(proof)
