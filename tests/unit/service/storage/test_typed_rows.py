"""Records as JSON: what comes back has the hash of what was kept."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose.storage.errors import UnreadableRowError
from truepose.storage.integrity.hash_chain import GENESIS, linked_hash
from truepose.storage.plant.outbox import from_typed_json, to_typed_json

VALUES = (
    st.none()
    | st.integers(-(2**63), 2**63 - 1)
    | st.text(st.characters(exclude_categories=["Cs"]))
    | st.binary()
    | st.floats(allow_nan=False)
)
ROWS = st.dictionaries(st.sampled_from(["id", "name", "document", "value", "archive"]), VALUES)


def hash_of(row):
    return linked_hash(GENESIS, "readings", tuple(row), tuple(row.values()))


@given(ROWS)
def test_what_comes_back_has_the_hash_of_what_was_kept(row):
    assert hash_of(from_typed_json(json.loads(json.dumps(to_typed_json(row))))) == hash_of(row)


@pytest.mark.parametrize("value", [0.1, -0.0, 5e-324, 1.7976931348623157e308, 3.0, math.inf])
def test_a_float_is_the_same_to_the_last_bit(value):
    came = from_typed_json(json.loads(json.dumps(to_typed_json({"value": value}))))["value"]

    assert came.hex() == value.hex()


def test_a_whole_number_is_no_float_and_no_text():
    kinds = [
        type(value)
        for value in from_typed_json(to_typed_json({"a": 3, "b": 3.0, "c": "3", "d": b"3"})).values()
    ]

    assert kinds == [int, float, str, bytes]


@pytest.mark.parametrize(
    "document",
    [
        *(7, [], "row", {"a": True}, {"a": 0.5}, {"a": []}, {"a": None}),
        *({"a": {"float": "one"}}, {"a": {"float": 1}}, {"a": {"float": "1", "base64": ""}}),
        {"a": {"base64": "!"}},
    ],
)
def test_what_is_no_record_is_said_to_be_none(document):
    with pytest.raises(UnreadableRowError):
        from_typed_json(document)
