"""Tables of cells and their plant, as schema 0013 makes them."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import BYTES, DOCUMENT, REAL, TEXT, WHOLE
from truepose.storage.migrations.columns import number, recorded, reference

_OF_CELL = ("handed_down", "hand_down_uses")
_COLLECTED = ("plant_cells", "plant_branches", "plant_visits", "plant_journal")
_SEEN = ("plant_sessions", "plant_days", "plant_results", "plant_robots", "plant_instruments")
_HANDED = ("plant_hand_downs", "plant_hand_down_states")
TABLES = (*_OF_CELL, *_COLLECTED, *_SEEN, *_HANDED)


def make_tables_of_plants() -> None:
    """Make the tables, a part each."""
    _of_cell()
    _collected()
    _journal()
    _measured()
    _seen()
    _handed()


def _text(name: str, *, nullable: bool = False) -> sa.Column[str]:
    return sa.Column(name, TEXT, nullable=nullable)


def _number(name: str, *, nullable: bool = False) -> sa.Column[int]:
    return sa.Column(name, WHOLE, nullable=nullable)


def _records(name: str, *columns: sa.schema.SchemaItem) -> None:
    op.create_table(name, number(), recorded(), *columns, sqlite_autoincrement=True)


def _of_cell() -> None:
    _records(
        "handed_down",
        *(_text(name) for name in ("plant", "kind", "name", "person")),
        sa.Column("document", DOCUMENT, nullable=False),
    )
    _records("hand_down_uses", reference("handed_down_id", "handed_down"), _text("person"), _text("note"))
    op.create_index("ix_hand_down_uses_handed_down_id", "hand_down_uses", ["handed_down_id", "id"])


def _collected() -> None:
    _records("plant_cells", sa.Column("name", TEXT, nullable=False, unique=True))
    _records(
        "plant_branches",
        reference("cell_id", "plant_cells"),
        reference("parent_id", "plant_branches", nullable=True),
        _number("after_link"),
        _text("person"),
        _text("reason"),
    )
    op.create_index("ix_plant_branches_cell_id", "plant_branches", ["cell_id", "id"])
    _records(
        "plant_visits",
        reference("cell_id", "plant_cells"),
        _text("outcome"),
        _text("sentence"),
        _number("collected"),
        _number("newest", nullable=True),
        _text("head", nullable=True),
        _number("fork", nullable=True),
        sa.Column("clock_offset_s", REAL, nullable=True),
        sa.Column("clock_bound_s", REAL, nullable=True),
        _text("version", nullable=True),
        _text("cell_schema", nullable=True),
    )
    op.create_index("ix_plant_visits_cell_id", "plant_visits", ["cell_id", "id"])


def _journal() -> None:
    _records(
        "plant_journal",
        reference("branch_id", "plant_branches"),
        _number("link"),
        _number("stream"),
        _text("record"),
        _number("record_id"),
        sa.Column("hash", BYTES, nullable=False),
        _text("content", nullable=True),
        _number("verified"),
        sa.UniqueConstraint("branch_id", "link", name="uq_plant_journal_link"),
    )
    op.create_index("ix_plant_journal_stream", "plant_journal", ["branch_id", "stream", "link"])
    op.create_index("ix_plant_journal_record", "plant_journal", ["branch_id", "record", "record_id"])


def _measured() -> None:
    _records(
        "plant_sessions",
        reference("branch_id", "plant_branches"),
        _number("session_id"),
        *(_text(name) for name in ("robot", "robot_serial_number", "instrument_serial_number")),
    )
    op.create_index("ix_plant_sessions_session_id", "plant_sessions", ["branch_id", "session_id", "id"])
    _records(
        "plant_days",
        reference("branch_id", "plant_branches"),
        _number("session_id"),
        *(_text(name) for name in ("measured_on", "robot_serial_number", "instrument_serial_number")),
        _number("readings"),
    )
    op.create_index("ix_plant_days_session_id", "plant_days", ["branch_id", "session_id"])
    op.create_index("ix_plant_days_robot", "plant_days", ["robot_serial_number", "measured_on"])
    op.create_index("ix_plant_days_instrument", "plant_days", ["instrument_serial_number", "measured_on"])


def _seen() -> None:
    _records(
        "plant_results",
        reference("branch_id", "plant_branches"),
        _text("kind"),
        _number("link"),
        _number("record_id"),
        *(_text(name) for name in ("name", "robot", "robot_serial_number", "instrument_serial_number")),
        _text("measured_on"),
        sa.Column("clock_offset_s", REAL, nullable=True),
        sa.UniqueConstraint("branch_id", "kind", "record_id", name="uq_plant_results_record"),
    )
    op.create_index("ix_plant_results_kind", "plant_results", ["kind", "id"])
    for seen in ("robot", "instrument"):
        columns = [f"{seen}_serial_number", "measured_on", "id"]
        op.create_index(f"ix_plant_results_{seen}", "plant_results", columns)
    serial_number = "serial_number"
    _records("plant_robots", sa.Column(serial_number, TEXT, nullable=False, unique=True), _text("robot"))
    _records("plant_instruments", sa.Column(serial_number, TEXT, nullable=False, unique=True))


def _handed() -> None:
    _records(
        "plant_hand_downs",
        reference("cell_id", "plant_cells"),
        *(_text(name) for name in ("kind", "name", "person")),
        sa.Column("document", DOCUMENT, nullable=False),
    )
    op.create_index("ix_plant_hand_downs_cell_id", "plant_hand_downs", ["cell_id", "id"])
    _records(
        "plant_hand_down_states",
        reference("hand_down_id", "plant_hand_downs"),
        _text("state"),
        _text("sentence"),
        _number("number_in_cell", nullable=True),
    )
    op.create_index(
        "ix_plant_hand_down_states_hand_down_id", "plant_hand_down_states", ["hand_down_id", "id"]
    )
