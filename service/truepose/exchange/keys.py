"""Documents that are read and written, described once: which key holds which field, in which form."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar

from truepose.exchange.document import Node
from truepose.exchange.json_text import Json, number_or_null

T = TypeVar("T")
_REQUIRED: Final = object()


@dataclass(frozen=True, slots=True)
class Form:
    """How a value stands in a document; `read` refuses what cannot be meant."""

    read: Callable[[Node], Any]
    write: Callable[[Any], Json] = lambda value: value


@dataclass(frozen=True, slots=True)
class Key:
    """A key of a document and the field that it holds; one with `absent` may be missing or null."""

    name: str
    field: str
    form: Form
    absent: object = _REQUIRED

    def read(self, node: Node) -> Any:
        """Return the value of the field."""
        if self.absent is _REQUIRED:
            return self.form.read(node.key(self.name))
        found = node.optional(self.name)
        return self.absent if found is None else self.form.read(found)

    def written(self, value: object) -> Json:
        """Return what stands under the key; null where the field is None."""
        held = getattr(value, self.field)
        return None if held is None else self.form.write(held)


def read_keys(node: Node, keys: Sequence[Key]) -> dict[str, Any]:
    """Return the fields that the keys hold; raises an InputFileError that names key and line."""
    return {key.field: key.read(node) for key in keys}


def written_keys(value: object, keys: Sequence[Key]) -> dict[str, Json]:
    """Return the keys that the fields of `value` are written under."""
    return {key.name: key.written(value) for key in keys}


def record(kind: type[T], keys: Sequence[Key]) -> Form:
    """Return the form of an object that is one dataclass."""
    return Form(lambda node: kind(**read_keys(node, keys)), lambda value: written_keys(value, keys))


def each(form: Form, count: int | None = None) -> Form:
    """Return the form of a list, `count` long where that is given."""
    return Form(
        lambda node: tuple(form.read(entry) for entry in node.items(count)),
        lambda values: [form.write(value) for value in values],
    )


def or_null(form: Form, unknown: object = None) -> Form:
    """Return the form of what may be null; `unknown` is what that means."""
    return Form(lambda node: unknown if node.is_null else form.read(node), form.write)


def number(*, above: float = -math.inf, least: float = -math.inf) -> Form:
    """Return the form of a finite number within limits."""
    return Form(lambda node: node.number(above=above, least=least))


def whole(*, least: float = -math.inf, greatest: float = math.inf) -> Form:
    """Return the form of a whole number within limits."""
    return Form(lambda node: node.whole(least=least, greatest=greatest))


def degrees(angle_rad: float) -> float:
    """Return an angle in degrees with 15 significant digits.

    The conversion there and back is off in the 16th digit; without the rounding a table of round
    numbers would come back as 33.00000000000001. What is lost is 5e-16 of the value.
    """
    return float(f"{math.degrees(angle_rad):.15g}")


NUMBER: Final = number()
UNKNOWN_OR_NUMBER: Final = Form(or_null(NUMBER, math.nan).read, number_or_null)
TEXT: Final = Form(Node.text)
TRUTH: Final = Form(Node.truth)
VECTOR: Final = Form(Node.vector, list)
ANGLE: Final = Form(lambda node: math.radians(node.number()), degrees)
