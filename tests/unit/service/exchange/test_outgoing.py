"""What leaves the program is read off values by the names of its fields."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from pydantic import ValidationError

from truepose.exchange.results.document import Outgoing, Quantities, Quantity


@dataclass(frozen=True, slots=True)
class Nest:
    number: int
    name: str = "T1"
    height_mm: float = 2.5


@dataclass(frozen=True, slots=True)
class Record:
    name: str
    nests: tuple[Nest, ...]


class NestReply(Outgoing):
    number: int
    height_mm: Quantity


class RecordReply(Outgoing):
    name: str
    number: int
    nests: list[NestReply]


class CurveReply(Outgoing):
    line: Quantities


def test_fields_are_found_by_name_also_inside_of_fields():
    reply = RecordReply.of(Record("left", (Nest(1), Nest(2))), number=7)

    assert reply.model_dump() == {
        "name": "left",
        "number": 7,
        "nests": [{"number": 1, "height_mm": 2.5}, {"number": 2, "height_mm": 2.5}],
    }


def test_what_is_said_beside_counts_before_every_value():
    record, nest = Record("left", ()), Nest(4)

    assert RecordReply.of(record, nest, name="right").name == "right"
    assert RecordReply.of(nest, record, name="right").number == 4


def test_a_name_that_two_values_have_is_taken_from_neither_of_them():
    record, nest = Record("left", ()), Nest(4)

    for values in ((record, nest), (nest, record)):
        with pytest.raises(ValidationError, match=r"AmbiguousNameError: .* and .* have name"):
            RecordReply.of(*values)


def test_a_name_that_nobody_has_is_an_error():
    with pytest.raises(ValidationError, match="number"):
        RecordReply.of(Record("left", ()), name="right")


@pytest.mark.parametrize("unknown", [math.nan, math.inf, -math.inf, None])
def test_what_is_no_number_is_null(unknown):
    assert NestReply.of(Nest(1), height_mm=unknown).height_mm is None


def test_columns_are_lists_with_null_where_nothing_is_known():
    curve = CurveReply.of(Record("left", ()), line=np.array([0.1, math.nan, -math.inf]))

    assert curve.line == [0.1, None, None]
    assert CurveReply.model_validate(curve.model_dump()) == curve  # the framework reads a reply once more
    assert CurveReply.of(curve, line=np.array([])).line == []
