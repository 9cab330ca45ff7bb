"""What all schemas share. Angles travel in deg and are kept in rad: `joints_deg` here, `joints_rad` there."""

import functools
import inspect
import json
import math
import re
import time
from collections.abc import Callable
from datetime import date
from typing import Annotated, Any, ClassVar, Final, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from truepose.domain.people import LONGEST_NAME, NAME_PATTERN, same_person, tidy_name
from truepose.exchange.results.document import Outgoing
from truepose.web.middleware.rights import current_request

TIME_HEADER: Final = b"truepose-time"
PressedAt = Annotated[
    float | None,
    Field(
        ge=0,
        description="Time of the button press: `Truepose-Time` of the latest response plus the time "
        "elapsed since. A request that was in transit for more than 3 s moves nothing. Null "
        "means now.",
        examples=[81234.5],
    ),
]


def time_s() -> float:
    """Return the time that every answer tells; it does not go back while the machine runs."""
    return time.monotonic()


def under_way_s(pressed_at_s: float | None) -> float:
    """Return for how long a tap was under way; 0 where it does not say."""
    # A browser that gives a request up leaves its bytes with the network, which may deliver them minutes
    # later: a confirmation moved a robot then (commit de3038be).
    return 0.0 if pressed_at_s is None else time_s() - pressed_at_s


Noun = TypeVar("Noun")
_DEGREES = re.compile(r"_deg(?=_|$)")

# A character that no reader of the schema takes for a space: what counts as one differs between them.
VISIBLE = r"[^\s\u0085\u00a0\u1680\u180e\u2000-\u200a\u2028\u2029\u202f\u205f\u3000\ufeff]"
KEY = r"^[!-~]+$"  # of a request: what every client can put into a header

ANOTHER_PERSON = "another_person"  # kind of a fault: the body names somebody who is not signed in

NUMBER_LIMIT = 2**31 - 1  # of a record; far beyond any cell's life, and every client's integer holds it
Number = Annotated[int, Field(ge=1, le=NUMBER_LIMIT)]
RecordId = Annotated[int, Field(ge=1, le=NUMBER_LIMIT, description="Number of the record.", examples=[3])]
RecordedAt = Annotated[
    str, Field(description="Time of recording: UTC, ISO 8601.", examples=["2026-05-04T09:12:33.125+00:00"])
]
Point = Annotated[list[float], Field(min_length=3, max_length=3, examples=[[512.4, -33.1, 640.2]])]
ReasonKey = Annotated[
    str,
    Field(
        description="Message key of the reason, the same in every language; empty for several messages or "
        "free text.",
        examples=["session.pause_asked"],
    ),
]
PromptAnswered = Annotated[
    int | None,
    Field(
        ge=1,
        le=NUMBER_LIMIT,
        description="`id` of the prompt that the person saw; the answer is refused if another prompt has "
        "replaced it. Null answers whichever prompt is open.",
        examples=[57],
    ),
]
PersonName = Annotated[
    str,
    Field(
        min_length=1,
        max_length=LONGEST_NAME,
        pattern=NAME_PATTERN,
        description="Name of the person at the cell.",
        examples=["Ada Byron"],
    ),
    AfterValidator(tidy_name),
]


class Request(BaseModel):
    """Request body: unknown keys are refused, numbers must be finite."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, strict=True)
    person_asks: ClassVar[bool] = True  # whom a body names as `person` is whoever sends it

    @model_validator(mode="before")
    @classmethod
    def _whole_numbers(cls, body: object) -> object:
        # JSON knows one kind of number: to a schema, and to many a client, 3.0 is the integer 3.
        try:
            return {key: whole(value) for key, value in body.items()} if isinstance(body, dict) else body
        except RecursionError as error:
            raise PydanticCustomError("too_deep", "the JSON is nested too deeply") from error

    @model_validator(mode="before")
    @classmethod
    def _of_whoever_asks(cls, body: object) -> object:
        """Let a body name nobody but whoever is signed in, and keep why it was sent."""
        asked = current_request()
        if not isinstance(body, dict) or not asked.caller.name:
            return body
        asked.reason = str(body["reason"]) if body.get("reason") else asked.reason
        if "person" not in cls.model_fields or not cls.person_asks:
            return body
        named = body.get("person")
        if isinstance(named, str) and not same_person(named, asked.caller.name):
            raise PydanticCustomError(
                ANOTHER_PERSON,
                "{who} is signed in here, not {named}",
                {
                    "who": asked.caller.name,
                    "named": tidy_name(named),
                },
            )
        return {**body, "person": asked.caller.name}

    def into(self, noun: Callable[..., Noun], **more: object) -> Noun:
        """Return a noun of the domain: its fields as the body says them under their names.

        `more` is what the body does not say, or says in another form.
        """
        said = {_kept_name(name): value for name, value in self}
        taken = [name for name in _fields(noun) if name in said and name not in more]
        return noun(**{name: _kept(name, said[name]) for name in taken}, **more)


def _day(value: object) -> object:
    # The strict mode of requests, meant for numbers, would take no text for a day; a lax one takes seconds.
    if not isinstance(value, str):
        return value
    if len(value) != len("2026-03-03"):
        raise ValueError("a date such as 2026-03-03 is required")
    return date.fromisoformat(value)


Day = Annotated[date, BeforeValidator(_day)]


def _sayable(document: dict[str, Any]) -> dict[str, Any]:
    """Refuse what Python reads as JSON and nobody else does: it is kept and sent on as it came."""
    try:
        json.dumps(document, allow_nan=False)
    except ValueError as error:
        said = "numbers must be finite, as NaN and Infinity are not valid JSON; send null or omit the key"
        raise PydanticCustomError("finite_number", said) from error
    except RecursionError as error:
        raise PydanticCustomError("too_deep", "the JSON is nested too deeply") from error
    return document


FreeDocument = Annotated[dict[str, Any], AfterValidator(_sayable)]  # of which the service knows no form
Simulated = Annotated[
    bool,
    Field(description="True if the readings are marked as simulated, without a real robot or instrument."),
]


def whole(value: object) -> object:
    """Return a number without fraction as an integer, in lists too; anything else as it is."""
    if isinstance(value, list):
        return [whole(entry) for entry in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


@functools.cache
def _fields(noun: Callable[..., object]) -> tuple[str, ...]:
    return tuple(inspect.signature(noun).parameters)


def _kept_name(name: str) -> str:
    return _DEGREES.sub("_rad", name)


def _kept(name: str, value: object) -> object:
    """Return what a body says as it is kept: lists as tuples, angles in rad."""
    if isinstance(value, list):
        return tuple(_kept(name, entry) for entry in value)
    return math.radians(value) if "_rad" in name and isinstance(value, float | int) else value


class Reply(Outgoing):
    """Response body; angles are in degrees."""

    model_config = ConfigDict(extra="forbid")

    @model_validator(mode="before")
    @classmethod
    def _angles(cls, value: object) -> object:
        return value if isinstance(value, dict | BaseModel) else _InDegrees(value)


class _InDegrees:
    """A value under the names that travel."""

    def __init__(self, value: object) -> None:
        self._value = value

    def __getattr__(self, name: str) -> object:
        if hasattr(self._value, name):
            return getattr(self._value, name)
        return _travels(getattr(self._value, _kept_name(name)))


def _travels(angle_rad: Any) -> Any:
    if angle_rad is None:
        return None
    if isinstance(angle_rad, float):
        return degrees((angle_rad,))[0]
    if angle_rad and isinstance(angle_rad[0], tuple):
        return [degrees(angles_rad) for angles_rad in angle_rad]
    return degrees(angle_rad)


def example(document: dict[str, Any]) -> ConfigDict:
    """Return the settings of a schema with an example."""
    return ConfigDict(json_schema_extra={"examples": [document]})


def degrees(angles_rad: tuple[float, ...]) -> list[float]:
    """Return angles in degrees, without the noise of the conversion."""
    # 1e-9 deg turns a 2 m arm by 35 fm: far below anything, far above the rounding of the product.
    return [round(math.degrees(angle), 9) for angle in angles_rad]
