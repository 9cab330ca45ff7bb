"""Models: read and download."""

from fastapi import APIRouter, Response

from truepose.exchange.models.file import model_text
from truepose.web.context import Here
from truepose.web.parameters import Id, PageQuery
from truepose.web.problems import problems
from truepose.web.schemas.results import ModelReply, model_reply

router = APIRouter(prefix="/models", tags=["models"])
_FILE = {"schema": {"type": "object"}, "example": {"format": "truepose-model", "version": 1}}


@router.get("", responses=problems(422, 503))
async def list_models(here: Here, page: PageQuery) -> list[ModelReply]:
    """List models, oldest first."""
    return [model_reply(record) for record in await here.results.models(page)]


@router.get("/{id}", responses=problems(404, 422, 503))
async def get_model(here: Here, id: Id) -> ModelReply:
    """Show a model: its parameters with their uncertainties."""
    return model_reply(await here.results.model(id))


@router.get(
    "/{id}/file",
    response_class=Response,
    responses={
        200: {"description": "The model file.", "content": {"application/json": _FILE}},
        **problems(404, 422, 503),
    },
)
async def download_model(here: Here, id: Id) -> Response:
    """Download the model file, which `truepose predict`, `validate` and `correct` take."""
    record = await here.results.model(id)
    saved_as = {"Content-Disposition": f'attachment; filename="model-{id}.json"'}
    return Response(model_text(record.model), media_type="application/json", headers=saved_as)
