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
        """Return what `more` says, and else the first of `values` that has the name."""
        return cls.model_validate(values[0] if len(values) == 1 and not more else _Joined(values, more))


class _Joined:
    """Several values as if they were one."""

    def __init__(self, values: tuple[object, ...], more: dict[str, object]) -> None:
        self._values = values
        self._more = more

    def __getattr__(self, name: str) -> object:
        if name in self._more:
            return self._more[name]
        for value in self._values:
            if hasattr(value, name):
                return getattr(value, name)
        raise AttributeError(name)


def _null_where_unknown(number: Any) -> Any:
    return None if number is None else number_or_null(number)


def _listed(numbers: Any) -> list[Any]:
    return [_null_where_unknown(number) for number in np.asarray(numbers, dtype=object).tolist()]


# JSON has no word for NaN and infinity.
Quantity = Annotated[float | None, BeforeValidator(_null_where_unknown)]
Quantities = Annotated[list[float | None], BeforeValidator(_listed)]
