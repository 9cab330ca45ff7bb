"""Which model a result is judged by, and on which robots that was made."""

from typing import Final

from truepose.storage.errors import ConflictError
from truepose.storage.records import ModelRecord
from truepose.web.context import Context
from truepose.web.results.kinds import Choice, Origin

_MOST_SHOWN: Final = 50


async def model_for(here: Context, origin: Origin, choice: Choice) -> ModelRecord:
    """Return the model chosen, else the newest of this robot; raises NotFoundError, ConflictError."""
    if choice.model_id is not None:
        return await here.results.model(choice.model_id)
    robot = (await here.sessions.setup(origin.record.id)).cell.robot.name
    newest = await models_of(here, robot, 1)
    if not newest:
        raise ConflictError(
            f"There is no model of {robot} yet, which says where poses are commanded: identify one first."
        )
    return newest[0]


async def models_of(here: Context, robot: str, count: int = _MOST_SHOWN) -> list[ModelRecord]:
    """Return the latest models of a robot, newest first."""
    return await here.results.newest_models(count, robot)


async def made_on(here: Context, model: ModelRecord) -> str:
    """Return the serial number of the robot that a model was made from; empty where nobody said."""
    campaign_id = await _campaign_id(here, model)
    numbers = () if campaign_id is None else (await here.campaigns.get(campaign_id)).session_ids
    if not numbers:
        return ""
    return (await here.sessions.setup(numbers[0])).cell.robot_serial_number


async def _campaign_id(here: Context, model: ModelRecord) -> int | None:
    if model.identification_id is not None:
        return (await here.results.identification(model.identification_id)).campaign_id
    if model.diagnosis_id is not None:
        return (await here.diagnoses.get(model.diagnosis_id)).campaign_id
    return None
