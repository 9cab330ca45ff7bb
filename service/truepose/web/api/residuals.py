"""How far each reading of a result is off, in columns: what its charts and tables are drawn from."""

import asyncio
import math
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import Field

from truepose.analysis.job_queue.tasks import judging_or_own, stored_campaign
from truepose.domain.campaign import Quantity
from truepose.domain.identification import Model
from truepose.web.api.spaces import model_and_campaign
from truepose.web.context import Context, Here
from truepose.web.resources import ACT, Id, resource
from truepose.web.schemas import Reply

if TYPE_CHECKING:
    from truepose.domain.arrays import FloatArray
    from truepose.reports.reading_residuals import ReadingResiduals, Variable

_ERROR_MM: Final = 5  # decimals of errors
_VALUE: Final = 3  # and of what they may depend on: micrometres, thousandths of a degree
Errors = Annotated[
    list[list[float]],
    Field(
        description="Observed minus predicted: x, y, z of a position, one number of a length.",
        examples=[[[0.012, -0.004, 0.021]]],
    ),
]


class VariableReply(Reply):
    """What an error may depend on, of each reading."""

    name: str = Field(
        description="joint, torque, reach, x, y, z, number, time, temperature or attachment.",
        examples=["joint"],
    )
    joint: int | None = Field(description="Of an angle or a torque; null otherwise.", examples=[4])
    unit: str = Field(description="Empty of what is counted.", examples=["deg"])
    values: list[float | None] = Field(description="Null where it is not known.", examples=[[12.5, -80.0]])


class ResidualsReply(Reply):
    """The readings of a result, a value of each column for each reading."""

    robot: str = Field(examples=["ABB IRB 120"])
    quantity: Quantity = Field(examples=["position"])
    config: list[int] = Field(description="Number of the configuration.", examples=[[1, 1, 2]])
    nest: list[int] = Field(description="Of the tool, from 1.", examples=[[1, 2, 1]])
    before_mm: Errors
    after_mm: Errors
    expected_mm: list[float] = Field(
        description="Root mean square of the size to be expected of noise, scatter and the uncertain model.",
        examples=[[0.031, 0.029, 0.033]],
    )
    variables: list[VariableReply]


def residuals_reply(found: "ReadingResiduals") -> ResidualsReply:
    """Return residuals with the digits that a chart needs."""
    return ResidualsReply(
        robot=found.robot,
        quantity=found.quantity,
        config=found.config.tolist(),
        nest=found.nest.tolist(),
        before_mm=_rounded(found.before_mm, _ERROR_MM),
        after_mm=_rounded(found.after_mm, _ERROR_MM),
        expected_mm=_rounded(found.expected_mm, _ERROR_MM),
        variables=[_variable_reply(one) for one in found.variables],
    )


def _variable_reply(variable: "Variable") -> VariableReply:
    values = [None if math.isnan(value) else value for value in _rounded(variable.values, _VALUE)]
    return VariableReply(name=variable.name, joint=variable.joint, unit=variable.unit, values=values)


def _rounded(values: "FloatArray", decimals: int) -> Any:
    return values.round(decimals).tolist()


router = resource(tags=["residuals"])


@router.get("/identifications/{id}/residuals", responses=ACT)
async def get_identification_residuals(here: Here, id: Id) -> ResidualsReply:
    """Show how far each reading is off: of those kept for validation, else of those identified from."""
    record = await here.results.identification(id)
    return await _residuals(here, record.model_id, record.campaign_id)


@router.get("/validations/{id}/residuals", responses=ACT)
async def get_validation_residuals(here: Here, id: Id) -> ResidualsReply:
    """Show how far each reading is off, of those that judged the model."""
    record = await here.results.validation(id)
    return await _residuals(here, record.model_id, record.campaign_id)


@router.get("/diagnoses/{id}/residuals", responses=ACT)
async def get_diagnosis_residuals(here: Here, id: Id) -> ResidualsReply:
    """Show how far each reading is off: of the nominal robot, and of the model a diagnosis ends with."""
    record = await here.diagnoses.get(id)
    return await _residuals(here, record.model_id, record.campaign_id)


async def _residuals(here: Context, model_id: int | None, campaign_id: int) -> ResidualsReply:
    model, content = await model_and_campaign(here, model_id, campaign_id)
    return await asyncio.to_thread(_judged, model, content)


def _judged(model: Model, content: bytes) -> ResidualsReply:
    from truepose.reports.reading_residuals import reading_residuals

    return residuals_reply(reading_residuals(model, judging_or_own(stored_campaign(content))))
