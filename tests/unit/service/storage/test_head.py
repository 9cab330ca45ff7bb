"""The head of the chain: a code that is printed, typed off, and compared."""

import sqlite3

import pytest

from truepose.storage.errors import ChainHeadError
from truepose.storage.integrity.head_hash import Head, contradiction, head_after, newest_head, read_head

HEAD = Head(4711, "K3QF-7ZWD-M2PA-XY5R")


@pytest.fixture
def chain():
    connection = sqlite3.connect(":memory:")
    connection.execute("CREATE TABLE links (id INTEGER PRIMARY KEY, stream INTEGER, hash BLOB)")
    links = [(0, 1), (1, 2), (2, 3), (1, 4), (2, 5)]
    connection.executemany(
        "INSERT INTO links (stream, hash) VALUES (?, ?)", [(stream, bytes([n]) * 32) for stream, n in links]
    )
    yield connection
    connection.close()


def test_the_head_of_a_chain_never_changes(chain):
    assert newest_head(chain).text == "5-OKDN-XCJK-H63J-HTD2"


def test_an_empty_chain_has_a_head():
    with sqlite3.connect(":memory:") as empty:
        empty.execute("CREATE TABLE links (id INTEGER PRIMARY KEY, stream INTEGER, hash BLOB)")

        assert newest_head(empty).links == 0
    empty.close()


def test_an_earlier_head_is_found_again_whatever_came_afterwards(chain):
    printed = newest_head(chain)
    chain.execute("INSERT INTO links (stream, hash) VALUES (3, ?)", (b"x" * 32,))

    assert head_after(chain, printed.links) == printed
    assert contradiction(chain, printed) is None


@pytest.mark.parametrize("link", [1, 2, 3, 4, 5])
def test_a_chain_computed_anew_in_any_session_has_another_head(chain, link):
    printed = newest_head(chain)
    chain.execute("UPDATE links SET hash = ? WHERE id >= ?", (b"x" * 32, link))

    assert "do not match the printed head" in contradiction(chain, printed)


def test_newest_records_that_were_taken_out_are_counted(chain):
    printed = newest_head(chain)
    chain.execute("DELETE FROM links WHERE id > 3")

    assert "The newest 2 records are missing" in contradiction(chain, printed)


@pytest.mark.parametrize(
    "typed", ["4711-K3QF-7ZWD-M2PA-XY5R", " 4711 k3qf 7zwd m2pa xy5r ", "4711-K3QF7ZWDM2PAXY5R"]
)
def test_a_head_is_read_as_people_type_it(typed):
    assert read_head(typed) == HEAD
    assert HEAD.text == "4711-K3QF-7ZWD-M2PA-XY5R"


@pytest.mark.parametrize(
    "typed", ["", "4711", "4711-K3QF-7ZWD-M2PA", "x-K3QF-7ZWD-M2PA-XY5R", "1-K3Q1-7ZWD-M2PA-XY5R"]
)
def test_what_is_no_head_is_said_to_be_none(typed):
    with pytest.raises(ChainHeadError, match="is not a chain head"):
        read_head(typed)
