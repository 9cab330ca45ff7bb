"""The figures of the service, for Prometheus."""

from fastapi import Request
from fastapi.responses import PlainTextResponse, Response

from truepose.web.context import Here
from truepose.web.observation.metrics import MEDIA_TYPE
from truepose.web.resources import outside_the_api

router = outside_the_api(tags=["health"])


@router.get("/metrics", response_class=PlainTextResponse)
async def get_metrics(request: Request, here: Here) -> Response:
    """Give every figure of the service in the text format of Prometheus."""
    program = {"version": here.version, "schema": here.database.schema}
    text = request.app.state.metrics.text(await here.lookout.state(), program)
    return Response(text, media_type=MEDIA_TYPE)
