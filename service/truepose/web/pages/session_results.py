"""What every kind of session result has in common: its sessions, page and form, and the model that judges."""

from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, TypeAlias

from fastapi import Depends, Query

from truepose.domain.validation import DecisionRule
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import message
from truepose.storage.errors import ConflictError
from truepose.storage.records import ModelRecord, SessionRecord
from truepose.web.context import Context
from truepose.web.schemas import NUMBER_LIMIT

if TYPE_CHECKING:
    from truepose.reports.report import Report


@dataclass(frozen=True, slots=True)
class Origin:
    """A session, and what its plan was asked for."""

    record: SessionRecord
    asked: Mapping[str, Any]  # empty where its stops were given

    @property
    def method(self) -> str:
        """How its stops were planned, as requests name it; empty where no test was asked for."""
        return str(self.asked.get("method") or self.record.test or "")


@dataclass(frozen=True, slots=True)
class Choice:
    """What whoever reads a result may choose."""

    model_id: Annotated[
        int | None, Query(ge=1, le=NUMBER_LIMIT, description="Model to validate; by default, the newest.")
    ] = None  # that is the one that was to be proved, where there is one
    limit_mm: Annotated[float | None, Query(gt=0, le=1000, description="Largest permissible error.")] = None
    rule: Annotated[
        DecisionRule, Query(description="Decision rule: how the decision takes the uncertainty into account.")
    ] = "guard band"


Chosen = Annotated[Choice, Depends()]


Made: TypeAlias = "Callable[[Context, Origin, Choice, Catalogue], Awaitable[Report]]"


@dataclass(frozen=True, slots=True)
class Entry:
    """A number, a choice or a model that a form asks for."""

    name: str  # in the body of the request; dots lead into it, and several of one name are a list
    label: str  # key of the catalogue
    kind: Literal["number", "choice", "model", "model or none"] = "number"
    value: float | str | None = ""  # "": it may be left out; None: whoever plans must say it
    least: float | None = None
    most: float | None = None
    choices: tuple[tuple[str, str], ...] = ()  # value, key of the catalogue


@dataclass(frozen=True, slots=True)
class Form:
    """How such a session is planned from a page."""

    meaning: str  # key of the catalogue
    entries: tuple[Entry, ...]
    body: Mapping[str, Any]  # what the request holds beside the entries
    path: str = "/api/v1/sessions"


@dataclass(frozen=True, slots=True)
class ResultKind:
    """A kind of result."""

    name: str  # in the address of its form
    title: str  # key of the catalogue
    is_of: Callable[[Origin], bool]
    report: "Made"
    judges: bool = False  # a model that the reader may choose
    limited: bool = False  # held against a limit that the reader may set
    form: Callable[[Context], Form] | None = field(default=None)  # None: planned elsewhere


async def origins_of(here: Context, records: Sequence[SessionRecord]) -> list[Origin]:
    """Return sessions with what was asked of the jobs that planned them."""
    asked = await here.jobs.plans_of([record.id for record in records])
    return [Origin(record, asked.get(record.id, {})) for record in records]


async def origin_of(here: Context, session_id: int) -> Origin:
    """Return one session so; raises NotFoundError."""
    (found,) = await origins_of(here, [await here.sessions.get(session_id)])
    return found


_MOST_SHOWN: Final = 50


async def model_for(here: Context, origin: Origin, choice: Choice) -> ModelRecord:
    """Return the model chosen, else the newest of this robot; raises NotFoundError, ConflictError."""
    if choice.model_id is not None:
        return await here.results.model(choice.model_id)
    robot = (await here.sessions.setup(origin.record.id)).cell.robot.name
    newest = await models_of(here, robot, 1)
    if not newest:
        raise ConflictError(message("refused.no_model_yet", robot=robot))
    return newest[0]


async def models_of(here: Context, robot: str, count: int = _MOST_SHOWN) -> list[ModelRecord]:
    """Return the latest models of a robot, newest first."""
    return await here.results.newest_models(count, robot)


async def robot_of_model(here: Context, model: ModelRecord) -> str:
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
