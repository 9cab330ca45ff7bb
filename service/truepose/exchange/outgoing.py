"""What leaves the program: documents and replies, read off the values that they are of."""

from typing import Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict

from truepose.exchange.json_text import number_or_null


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
