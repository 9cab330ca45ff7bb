"""What all documents of results share: what `--json` prints, the REST API shows and its schema describes.

A document reads the values of the domain by their names; what differs from them says so beside its field.
"""

from typing import Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict

from truepose.exchange.json_text import Json, number_or_null


class Document(BaseModel):
    """A document of the command line; keys may be added to it, never renamed."""

    model_config = ConfigDict(extra="allow", from_attributes=True)

    @classmethod
    def of(cls, value: object) -> Self:
        """Return the document of a value of the domain."""
        return cls.model_validate(value)

    def printed(self) -> dict[str, Json]:
        """Return the document as JSON has it; keys that were not given are absent."""
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True)


def _null_where_unknown(number: Any) -> Any:
    return None if number is None else number_or_null(number)


def _listed(numbers: Any) -> list[Any]:
    return [_null_where_unknown(number) for number in np.asarray(numbers, dtype=object).tolist()]


# JSON has no word for NaN and infinity.
Quantity = Annotated[float | None, BeforeValidator(_null_where_unknown)]
Quantities = Annotated[list[float | None], BeforeValidator(_listed)]
