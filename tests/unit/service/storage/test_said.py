"""What is said to people comes back as it was kept: messages as messages, words as words."""

import pytest
import sqlalchemy as sa
from hypothesis import given
from hypothesis import strategies as st

from truepose.messages.message import message, together
from truepose.storage.engine.dialects import SAID
from truepose.storage.errors import DamagedDatabaseError

TABLE = sa.Table(
    "told", sa.MetaData(), sa.Column("id", sa.Integer, primary_key=True), sa.Column("text", SAID)
)
WORDS = [
    "",
    "Lunch.",
    '{"key": "session.finished", "values": []}',
    '"quoted"',
    "{",
    '{"a": 1}',
    "[1]",
    "null",
]


@pytest.fixture(scope="module")
def connection():
    engine = sa.create_engine("sqlite://")
    with engine.begin() as opened:
        TABLE.create(opened)
        yield opened
    engine.dispose()


def kept(connection, text):
    number = connection.execute(TABLE.insert().values(text=text)).inserted_primary_key[0]
    return connection.scalar(sa.select(TABLE.c.text).where(TABLE.c.id == number))


@pytest.mark.parametrize("words", WORDS)
def test_words_of_a_person_come_back_as_words_whatever_they_look_like(connection, words):
    assert kept(connection, words) == words


def test_any_words_come_back(connection):
    @given(st.text(st.characters(codec="utf-8")))
    def come_back(words):
        assert kept(connection, words) == words

    come_back()


@pytest.mark.parametrize(
    "said",
    [
        message("session.finished"),
        message("session.reading.scatters", off_mm=0.123, limit_mm=0.1),
        together(message("session.stopped"), "Bob says: lunch.", message("session.cell_clear")),
        message("session.nests.moved.either", what=(message("session.nests.off", nest=2, off_mm=0.3),)),
    ],
)
def test_a_message_comes_back_as_the_same_message(connection, said):
    assert kept(connection, said) == said


@pytest.mark.parametrize("damaged", ["{not JSON", '"neither', '{"values": []}'])
def test_what_holds_neither_is_damaged(connection, damaged):
    number = connection.execute(TABLE.insert().values(text="")).inserted_primary_key[0]
    asked = sa.text("UPDATE told SET text = :damaged WHERE id = :number")
    connection.execute(asked, {"damaged": damaged, "number": number})

    with pytest.raises(DamagedDatabaseError, match="cannot be read"):
        connection.scalar(sa.select(TABLE.c.text).where(TABLE.c.id == number))
