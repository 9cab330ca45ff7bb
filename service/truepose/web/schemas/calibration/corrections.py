"""Corrected files: what was asked, what it came to, and each target."""

import math

from pydantic import Field

from truepose.domain.results.corrections import CorrectedTargets
from truepose.exchange.outgoing import Quantity
from truepose.exchange.results.corrections import CorrectionDocument, correction_of
from truepose.storage.records import CorrectionRecord
from truepose.web.schemas.base import RecordedAt, RecordId, Reply, Simulated
from truepose.words.catalogue import english


class AskedReply(Reply):
    """How the file was meant; null: as its format has it."""

    frame: str | None = None
    define: list[str] = Field([], description="Frames that the file only names.")
    branch: str | None = None
    angles: str | None = None
    coupled: bool = Field(False, description="Whether joint 3 of FANUC counts from the horizontal.")
    as_written: bool = Field(
        False, description="Whether the numbers are meant so where another unit or frame fits better."
    )
    beside: list[str] = Field([], description="Names of the files beside it.")


class CorrectionReply(Reply):
    """A stored correction of a file of targets."""

    id: RecordId
    recorded_at: RecordedAt
    job_id: RecordId
    model_id: RecordId
    robot: str = Field(examples=["ABB IRB 120"])
    simulated: Simulated
    name: str = Field(description="Of the file.", examples=["weld.mod"])
    original_sha256: str
    corrected_sha256: str
    asked: AskedReply
    document: CorrectionDocument
    left_alone_count: int = Field(description="The document tells the first 500 of them.")
    largest_shift_mm: Quantity = Field(
        description="From the place meant to the one that the controller is told; null: none was corrected."
    )
    cautions: list[str] = Field(
        description="What the predictions do not contain, and what was not understood."
    )
    file_url: str = Field(examples=["/api/v1/corrections/3/file"])
    targets_url: str = Field(examples=["/api/v1/corrections/3/targets"])


class TargetReply(Reply):
    """A target of a file."""

    number: int = Field(ge=1, description="In the file, from 1.")
    name: str
    line: int
    status: str = Field(examples=["ok"])
    place_mm: list[Quantity] = Field(description="Meant for the origin of the last frame, in the base.")
    shift_mm: list[Quantity] = Field(description="From there to where the controller is told to go.")
    u_mm: Quantity = Field(description="Standard, per axis, of where the tool really goes.")
    outside_mm: Quantity = Field(description="How far outside the measured zone; null: unknown.")
    moved_deg: Quantity = Field(description="Of a joint, from the controller's own answer.")


def correction_reply(record: CorrectionRecord) -> CorrectionReply:
    """Return a correction as it travels."""
    found, path = record.correction, f"/api/v1/corrections/{record.id}"
    return CorrectionReply.of(
        record,
        asked=AskedReply(**record.asked),
        document=correction_of(found.totals, found.left_alone),
        left_alone_count=found.left_alone_count,
        largest_shift_mm=found.largest_shift_mm,
        cautions=list(map(english, found.cautions)),
        file_url=f"{path}/file",
        targets_url=f"{path}/targets",
    )


def target_replies(targets: CorrectedTargets, after: int, limit: int) -> list[TargetReply]:
    """Return some targets as they travel, from the one behind number `after` on."""
    return [
        TargetReply(
            number=row + 1,
            name=targets.names[row],
            line=int(targets.lines[row]),
            status=targets.statuses[row],
            place_mm=targets.place_mm[row].tolist(),
            shift_mm=targets.shift_mm[row].tolist(),
            u_mm=float(targets.uncertainty_mm[row]),
            outside_mm=float(targets.outside_mm[row]),
            moved_deg=math.degrees(targets.moved_rad[row]),
        )
        for row in range(after, min(after + limit, len(targets.names)))
    ]
