"""What documents of results and replies share: fields read off values, null, statistics of errors.

A document is its own description: a field is called as in the value that it is made of, or says with
`FieldSource` where else it stands there, and in which unit the document has it.
"""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Annotated, Any, Final, Self, TypeAlias

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from truepose.domain.identification import Statistics
from truepose.exchange.json_text import Json, number_or_null
from truepose.exchange.models.document import file_factor, file_unit
from truepose.messages.catalogue import english
from truepose.messages.message import Message


@dataclass(frozen=True, slots=True)
class FieldSource:
    """Where a value has what a field says, by names with dots between, and what is made of it there."""

    path: str
    convert: Callable[[Any], Any] | None = None

    def of(self, value: object) -> Any:
        """Return what the field says; None stays None."""
        found = attrgetter(self.path)(value) if self.path else value
        return found if found is None or self.convert is None else self.convert(found)


def in_degrees(path: str) -> FieldSource:
    """Return where an angle in rad, or several of them, stand that a document has in deg."""
    return FieldSource(path, np.degrees)


def null_if_empty(path: str) -> FieldSource:
    """Return where a text, or a number, stands that nobody said where it is empty, or 0."""
    return FieldSource(path, lambda found: found or None)


def in_file_unit(name: str) -> FieldSource:
    """Return where a quantity stands whose unit is said beside it; in the unit that files have for that."""
    return FieldSource("", lambda value: np.multiply(getattr(value, name), file_factor(value.unit)))


UNIT: Final = FieldSource("unit", file_unit)


class Outgoing(BaseModel):
    """A description of what travels; its fields have the names that the values themselves use."""

    # Built when first used: most commands print one kind of document, and importing builds none.
    model_config = ConfigDict(from_attributes=True, defer_build=True)

    @classmethod
    def of(cls, *values: object, **more: object) -> Self:
        """Return what `more` says, and else the one of `values` that has the name.

        Raises AmbiguousNameError where several of them have it: which is meant, `more` must say.
        """
        return cls.model_validate(values[0] if len(values) == 1 and not more else _Joined(values, more))

    @model_validator(mode="before")
    @classmethod
    def _taken(cls, value: object) -> object:
        """Return a value with what its fields are made of; what is a document already stays as it is."""
        sources = _sources(cls)
        if not sources or isinstance(value, Mapping | Outgoing):
            return value
        said = getattr(value, "_more", {})
        return _Joined((value,), {name: one.of(value) for name, one in sources if name not in said})


@functools.cache
def _sources(kind: type[BaseModel]) -> tuple[tuple[str, FieldSource], ...]:
    fields = kind.model_fields.items()
    return tuple(
        (name, one) for name, field in fields for one in field.metadata if isinstance(one, FieldSource)
    )


class AmbiguousNameError(Exception):
    """Several values have a name, and nobody said which of them is meant."""


class _Joined:
    """Several values as if they were one."""

    def __init__(self, values: tuple[object, ...], more: dict[str, object]) -> None:
        self._values = values
        self._more = more

    def __getattr__(self, name: str) -> object:
        if name in self._more:
            return self._more[name]
        # All of them are asked, not the first: two values that share a name would else be told apart by the
        # order of arguments.
        having = [value for value in self._values if hasattr(value, name)]
        if not having:
            raise AttributeError(name)
        if len(having) > 1:
            raise AmbiguousNameError(f"{' and '.join(type(value).__name__ for value in having)} have {name}")
        return getattr(having[0], name)


def _null_where_unknown(number: Any) -> Any:
    return None if number is None else number_or_null(number)


def _listed(numbers: Any) -> list[Any]:
    return [_null_where_unknown(number) for number in np.asarray(numbers, dtype=object).tolist()]


# JSON has no word for NaN and infinity.
Quantity = Annotated[float | None, BeforeValidator(_null_where_unknown)]
Quantities = Annotated[list[float | None], BeforeValidator(_listed)]
Rows = Annotated[list[Quantities], BeforeValidator(list)]
Integers = Annotated[list[int], BeforeValidator(lambda numbers: np.asarray(numbers).tolist())]


def _in_english(value: object) -> object:
    return english(value) if isinstance(value, Message) else value


Spoken: TypeAlias = Annotated[
    str, BeforeValidator(_in_english)
]  # documents are in English, whoever reads them
# A type, not one `Field` for several documents: older versions of pydantic write what one document adds into
# the field itself, and the others then read it.
SpokenOutcome: TypeAlias = Annotated[
    Spoken,
    Field(
        description="One-sentence summary of the result: error before and after, limit, pass or fail.",
        examples=[
            "Mean error 0.499 mm before (nominal), 0.033 mm after; largest 0.0811 mm, limit 0.1 mm: pass."
        ],
    ),
]


class Document(Outgoing):
    """Document printed by a command; keys may be added but are never renamed."""

    model_config = ConfigDict(extra="allow")

    def printed(self) -> dict[str, Json]:
        """Return the document as JSON has it; keys that were not given are absent."""
        # A key is absent where this kind of result has no such thing, and null where it has it and nobody
        # knows it.
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True)


class StatisticsDocument(Document):
    """Statistics of n error norms; `noise_mm` is the mean norm due to the stated uncertainties alone."""

    n: int = Field(examples=[50])
    mean_mm: Quantity = Field(examples=[0.021])
    rms_mm: Quantity = Field(examples=[0.023])
    sd_mm: Quantity = Field(examples=[0.009])
    max_mm: Quantity = Field(examples=[0.047])
    noise_mm: Quantity = Field(examples=[0.019])


class PairDocument(Document):
    """Statistics for the nominal and the identified model."""

    nominal: StatisticsDocument
    identified: StatisticsDocument


class TurnStatisticsDocument(Document):
    """Angles between measured and predicted orientations; `noise_deg` is due to the stated noise alone."""

    n: int = Field(examples=[50])
    mean_deg: Annotated[Quantity, in_degrees("mean_rad")] = Field(examples=[0.035])
    rms_deg: Annotated[Quantity, in_degrees("rms_rad")] = Field(examples=[0.038])
    sd_deg: Annotated[Quantity, in_degrees("sd_rad")] = Field(examples=[0.015])
    max_deg: Annotated[Quantity, in_degrees("max_rad")] = Field(examples=[0.081])
    noise_deg: Annotated[Quantity, in_degrees("noise_rad")] = Field(examples=[0.043])


class TurnPairDocument(Document):
    """Orientation statistics for the nominal and the identified model."""

    nominal: TurnStatisticsDocument
    identified: TurnStatisticsDocument


def statistics_document(statistics: Statistics) -> dict[str, Json]:
    """Return a statistics block: the same six keys everywhere."""
    return StatisticsDocument.of(statistics).printed()
