"""The hash of a record: fixed for good, and another one for every other content."""

import pytest

from truepose.storage.integrity.hash_chain import GENESIS, linked_hash

NAMES = ("id", "recorded_at", "session_id", "text", "value")
ROW = (7, "2026-05-04T09:12:33.125+00:00", 3, "grün", 0.1)
BEFORE = linked_hash(GENESIS, "notes", NAMES, ROW)


def test_the_hash_of_a_record_never_changes():
    assert BEFORE.hex() == "1cd318b4e95a751168a10739065c9e632123f287d38c9345fc1fb1a0b718ecc1"


def test_a_column_that_a_later_schema_adds_changes_nothing_where_it_is_empty():
    assert linked_hash(GENESIS, "notes", (*NAMES, "added"), (*ROW, None)) == BEFORE


def test_a_text_that_was_not_decoded_counts_as_the_same_text():
    undecoded = (7, bytearray(ROW[1].encode()), 3, bytearray("grün".encode()), 0.1)

    assert linked_hash(GENESIS, "notes", NAMES, undecoded) == BEFORE


@pytest.mark.parametrize(
    ("record", "row"),
    [
        ("note", ROW),
        ("notes", (8, *ROW[1:])),
        ("notes", (7, ROW[1], 3, "grun", 0.1)),
        ("notes", (7, ROW[1], 3, "grün".encode(), 0.1)),
        ("notes", (7, ROW[1], 3, "grün", 0.10000000000000002)),
        ("notes", (7, ROW[1], 3, "grün", None)),
        ("notes", (7, ROW[1], "3", "grün", 0.1)),
        ("notes", (7, ROW[1], 3.0, "grün", 0.1)),
    ],
)
def test_whatever_differs_has_another_hash(record, row):
    assert linked_hash(GENESIS, record, NAMES, row) != BEFORE


def test_the_same_record_elsewhere_in_the_chain_has_another_hash():
    assert linked_hash(BEFORE, "notes", NAMES, ROW) != BEFORE
