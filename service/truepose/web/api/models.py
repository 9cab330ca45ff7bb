"""Models: read, and download as themselves or for other programs."""

import asyncio
from typing import Annotated, Final

from fastapi import Query, Response
from pydantic import Field

from truepose.exchange.models.exports import Format, export
from truepose.exchange.models.file import model_text
from truepose.exchange.results.document import Quantity
from truepose.exchange.results.identification import ParameterDocument
from truepose.storage.records import ModelRecord
from truepose.web.context import Here
from truepose.web.resources import ACT, LIST, READ, Id, Paged, resource, sending
from truepose.web.schemas import RecordedAt, RecordId, Reply, Simulated


class ModelReply(Reply):
    """An identified model; its file holds the complete model for `truepose predict` and `correct`."""

    id: RecordId
    recorded_at: RecordedAt
    identification_id: RecordId | None = Field(
        description="Identification that created the model; null if there is none."
    )
    diagnosis_id: RecordId | None = Field(
        description="Diagnosis that created the model; null if there is none."
    )
    handed_down_id: RecordId | None = Field(
        description="Number under which a plant pushed the model; null if it was created here."
    )
    accepted_by: str | None = Field(description="Person who accepted the model; null if it was created here.")
    robot: str = Field(examples=["ABB IRB 120"])
    simulated: Simulated
    effects: list[str] = Field(examples=[["base", "geometry", "compliance"]])
    parameters: list[ParameterDocument]
    repeatability_mm: Quantity = Field(
        description="Repeatability of the arm (standard deviation per axis).", examples=[0.0035]
    )
    discrepancy_mm: Quantity = Field(
        description="Model discrepancy: held-out residuals beyond noise, per axis."
    )
    program_version: str
    file_url: str = Field(examples=["/api/v1/models/3/file"])


def model_reply(record: ModelRecord) -> ModelReply:
    """Return a model as it travels."""
    file_url = f"/api/v1/models/{record.id}/file"
    return ModelReply.of(record, record.model, robot=record.robot, file_url=file_url)


router = resource("/models", tags=["models"])
_MEDIA: Final[dict[Format, tuple[str, str]]] = {  # media type, and how the file is called
    "urdf": ("application/xml", "model-{id}.urdf"),
    "ros": ("application/yaml", "model-{id}-calibrated_kinematics.yaml"),
    "dhm": ("text/plain", "model-{id}-table.txt"),
    "controller": ("text/plain", "model-{id}-controller.txt"),
}
_EXPORTS = {media: {"schema": {"type": "string"}} for media, _ in _MEDIA.values()}
_FILE = {"schema": {"type": "object"}, "example": {"format": "truepose-model", "version": 1}}


@router.get("", responses=LIST)
async def list_models(here: Here, paging: Paged) -> list[ModelReply]:
    """List models, oldest first."""
    return paging.shown(await here.results.models(paging.page), model_reply)


@router.get("/{id}", responses=READ)
async def get_model(here: Here, id: Id) -> ModelReply:
    """Return a model: its parameters and their uncertainties."""
    return model_reply(await here.results.model(id))


@router.get(
    "/{id}/file",
    response_class=Response,
    responses=sending("The model file.", {"application/json": _FILE}) | READ,
)
async def download_model(here: Here, id: Id) -> Response:
    """Download the model file for `truepose predict`, `validate` and `correct`."""
    record = await here.results.model(id)
    saved_as = {"Content-Disposition": f'attachment; filename="model-{id}.json"'}
    return Response(model_text(record.model), media_type="application/json", headers=saved_as)


@router.get(
    "/{id}/exports/{form}",
    response_class=Response,
    responses=sending(
        "The exported file; it lists the parts of the model that it does not contain.", _EXPORTS
    )
    | ACT,
)
async def download_export(
    here: Here,
    id: Id,
    form: Format,
    fitted: Annotated[
        bool, Query(description="True: fit the table to the full model over the measured zone.")
    ] = False,
) -> Response:
    """Export a model for another program, as `truepose export` does."""
    record = await here.results.model(id)
    exported = await asyncio.to_thread(export, record.model, form, fitted=fitted)
    media, name = _MEDIA[form]
    saved_as = {"Content-Disposition": f'attachment; filename="{name.format(id=id)}"'}
    return Response(exported.text, media_type=media, headers=saved_as)
