"""What a table keeps of a noun, and the noun that comes of a row again."""

from dataclasses import dataclass
from types import SimpleNamespace

import pytest
import sqlalchemy as sa

from truepose.domain.session import SessionState, StopSkipped
from truepose.messages.message import Text, message
from truepose.storage.engine.dialects import BYTES, DOCUMENT, SAID, TEXT, WHOLE
from truepose.storage.errors import DamagedDatabaseError
from truepose.storage.rows import from_row, to_row


@dataclass(frozen=True)
class Told:
    state: SessionState
    whole: bool
    sentence: Text
    packed: bytes
    numbers: tuple[int, ...]
    skipped: StopSkipped
    note: str | None = None
    beside: float = 0.0  # in no column


KINDS = {
    **{"state": TEXT, "whole": WHOLE, "sentence": SAID, "packed": BYTES},
    **{"numbers": DOCUMENT, "skipped": DOCUMENT, "note": TEXT},
}
TABLE = sa.Table("told", sa.MetaData(), *(sa.Column(name, kind) for name, kind in KINDS.items()))
TOLD = Told(
    SessionState.PAUSED,
    True,
    message("session.finished"),
    b"\0",
    (1, 2),
    StopSkipped(3, 1.0, "lunch"),
    None,
    7.0,
)


@pytest.fixture
def row():
    engine = sa.create_engine("sqlite://")
    with engine.connect() as connection:
        TABLE.create(connection)
        connection.execute(TABLE.insert().values(**to_row(TOLD, TABLE)))
        yield connection.execute(sa.select(TABLE)).one()
    engine.dispose()


def test_a_noun_comes_back_from_its_row_with_what_is_given_beside(row):
    assert from_row(Told, row, beside=7.0) == TOLD


def test_a_table_is_given_what_its_columns_take():
    kept = to_row(TOLD, TABLE)

    assert kept.keys() == set(KINDS)
    assert [type(kept[name]) for name in ("state", "whole", "packed", "numbers")] == [str, int, bytes, list]


def test_a_column_that_does_not_hold_what_its_field_is_is_damaged(row):
    with pytest.raises(DamagedDatabaseError, match="A stored StopSkipped cannot be read"):
        from_row(Told, SimpleNamespace(**row._asdict() | {"skipped": []}), beside=7.0)
