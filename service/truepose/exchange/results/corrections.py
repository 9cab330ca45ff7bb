"""What a table of corrected targets came to, as a document."""

import math
from collections.abc import Sequence

from pydantic import Field

from truepose.domain.results.corrections import CorrectionTotals, LeftAlone
from truepose.exchange.json_text import Json
from truepose.exchange.outgoing import Quantity
from truepose.exchange.results.document_base import Document, Spoken


class FailedTarget(Document):
    """A target that was not corrected, and why."""

    target: str
    status: str = Field(examples=["out_of_reach"])


class LeftAloneDocument(Document):
    """A place of a program, and why its numbers are as they were."""

    line: int
    what: str = Field(examples=["MoveL Offs(p10,0,0,50)"])
    reason: Spoken
    file: str | None = Field(description="Null: of the program itself.")


class CorrectionDocument(Document):
    """Counts and extremes of a table of targets; errors are the model's, uncertainties those of the robot."""

    targets: int
    corrected: int
    statuses: dict[str, int] = Field(examples=[{"ok": 998, "out_of_reach": 2}])
    not_corrected: list[FailedTarget] = Field(description="The first hundred.")
    largest_error_mm: Quantity
    mean_u_mm: Quantity = Field(description="Standard, per axis.")
    largest_u_mm: Quantity
    far_moved: int = Field(description="Corrected ones at which a joint turns by more than 5 deg.")
    largest_move_deg: Quantity = Field(description="Of a joint, from the controller's own answer.")
    outside: int | None = Field(description="Corrected ones outside the measured zone; null: it is unknown.")
    farthest_outside_mm: Quantity | None = Field(description="Of the last frame.")
    farthest_outside_deg: Quantity | None = Field(description="Of a joint.")
    left_alone: list[LeftAloneDocument] = Field(
        description="What moves the robot of a program and is not corrected by changing numbers."
    )


def correction_document(totals: CorrectionTotals, left_alone: Sequence[LeftAlone] = ()) -> dict[str, Json]:
    """Return what `truepose correct --json` prints."""
    return correction_of(totals, left_alone).printed()


def correction_of(totals: CorrectionTotals, left_alone: Sequence[LeftAlone] = ()) -> CorrectionDocument:
    """Return the document of a correction."""
    return CorrectionDocument(
        targets=totals.targets,
        corrected=totals.solved,
        statuses=dict(totals.statuses),
        not_corrected=[FailedTarget(target=name, status=status) for name, status in totals.failed],
        largest_error_mm=totals.largest_error_mm,
        mean_u_mm=totals.mean_uncertainty_mm,
        largest_u_mm=totals.largest_uncertainty_mm,
        far_moved=totals.far_moved,
        largest_move_deg=math.degrees(totals.largest_move_rad),
        outside=totals.outside if totals.zone_known else None,
        farthest_outside_mm=totals.farthest_outside_mm if totals.zone_known else None,
        farthest_outside_deg=math.degrees(totals.farthest_outside_rad) if totals.zone_known else None,
        left_alone=[LeftAloneDocument.of(left) for left in left_alone],
    )
