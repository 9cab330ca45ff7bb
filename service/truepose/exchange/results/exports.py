"""What was written of a model for another program, as a document."""

import math
from typing import Any

from pydantic import Field

from truepose.correction.reduced_models import ControllerValues
from truepose.domain.robot import FramePlacement
from truepose.exchange.json_text import Json
from truepose.exchange.models.exports import Export
from truepose.exchange.models.rigid_arm import Subject
from truepose.exchange.results.document import Document, Spoken
from truepose.exchange.robots.document import PLACEMENT


class ZoneErrorDocument(Document):
    """Prediction error over the measured zone."""

    mean_mm: float = Field(examples=[0.021])
    max_mm: float = Field(examples=[0.094])


class LeftOutDocument(Document):
    """An effect of the model that the file format cannot represent."""

    effect: str = Field(examples=["compliance"])
    parameters: int = Field(examples=[5])


class ToolPointDocument(Document):
    """Centre of a tool nest in the flange frame of the controller."""

    nest: int
    centre_mm: tuple[float, float, float]


class ExportDocument(Document):
    """Result of `truepose export --json`; some fields apply to tables only, others to controllers only."""

    form: str = Field(serialization_alias="as", examples=["urdf"])
    robot: str = Field(examples=["ABB IRB 120"])
    remarks: list[Spoken]
    nominal_error: ZoneErrorDocument | None = Field(
        description="Error of the nominal robot relative to the full model."
    )
    error: ZoneErrorDocument | None = Field(
        description="Error of the exported file relative to the full model."
    )

    fitted: bool | None = Field(None, description="True if the table was fitted to the full model.")
    left_out: list[LeftOutDocument] | None = None

    model_error: ZoneErrorDocument | None = Field(
        None, description="Expected error of the full model itself."
    )
    joint_zeros_deg: list[float] | None = Field(
        None, description="True joint angle minus displayed joint angle."
    )
    base_in_world: dict[str, Any] | None = None
    world_in_base: dict[str, Any] | None = None
    tool_points: list[ToolPointDocument] | None = None
    tool_frame: dict[str, Any] | None = Field(
        None,
        description="Frame with its origin at nest 1, x axis towards nest 2, and nest 3 in the x-y plane.",
    )


def export_document(export: Export, robot: str) -> dict[str, Json]:
    """Return the document of an export."""
    more = _table(export.subject) if export.subject else {}
    if export.values:
        more = _controller(export.values)
    more["remarks"] = list(export.remarks)
    return ExportDocument(form=export.form, robot=robot, **more).printed()


def _table(subject: Subject) -> dict[str, Any]:
    return {
        "nominal_error": subject.nominal,
        "error": subject.error,
        "fitted": subject.fitted,
        "left_out": [LeftOutDocument(effect=name, parameters=n) for name, n in subject.left_out.items()],
    }


def _controller(values: ControllerValues) -> dict[str, Any]:
    return {
        "nominal_error": values.nominal,
        "error": values.controller,
        "model_error": values.model,
        "joint_zeros_deg": [math.degrees(zero) for zero in values.joint_zeros_rad],
        "base_in_world": PLACEMENT.write(values.base),
        "world_in_base": PLACEMENT.write(values.world),
        "tool_points": list(values.tool_points),
        "tool_frame": _placement(values.tool_frame),
    }


def _placement(placement: FramePlacement | None) -> Json:
    return None if placement is None else PLACEMENT.write(placement)
