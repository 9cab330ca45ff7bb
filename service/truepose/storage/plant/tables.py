"""What a plant has of its cells, as the newest migration leaves it; append-only as all tables are."""

import sqlalchemy as sa

from truepose.storage.engine.dialects import BYTES, DOCUMENT, REAL, TEXT, WHOLE, records, reference

plant_cells = records("plant_cells", sa.Column("name", TEXT, nullable=False, unique=True))

plant_branches = records(
    "plant_branches",
    reference("cell_id", "plant_cells"),
    reference("parent_id", "plant_branches", nullable=True),  # none: of the first one
    sa.Column("after_link", WHOLE, nullable=False),  # the last link that it shares with its parent
    sa.Column("person", TEXT, nullable=False),  # who accepted it; empty: the first one needs nobody
    sa.Column("reason", TEXT, nullable=False),
    sa.Index("ix_plant_branches_cell_id", "cell_id", "id"),
)

plant_visits = records(
    "plant_visits",
    reference("cell_id", "plant_cells"),
    sa.Column("outcome", TEXT, nullable=False),
    sa.Column("sentence", TEXT, nullable=False),  # empty: nothing is amiss
    sa.Column("collected", WHOLE, nullable=False),  # links
    sa.Column("newest", WHOLE, nullable=True),  # link of the cell; null: it did not answer
    sa.Column("head", TEXT, nullable=True),  # of what was collected so far, as reports print it
    sa.Column("fork", WHOLE, nullable=True),  # last link in common with another chain
    sa.Column("clock_offset_s", REAL, nullable=True),  # cell's clock less the plant's
    sa.Column("clock_bound_s", REAL, nullable=True),  # the offset is known within so much
    sa.Column("version", TEXT, nullable=True),
    sa.Column("cell_schema", TEXT, nullable=True),
    sa.Index("ix_plant_visits_cell_id", "cell_id", "id"),
)

plant_journal = records(
    "plant_journal",
    reference("branch_id", "plant_branches"),
    sa.Column("link", WHOLE, nullable=False),
    sa.Column("stream", WHOLE, nullable=False),
    sa.Column("record", TEXT, nullable=False),
    sa.Column("record_id", WHOLE, nullable=False),
    sa.Column("hash", BYTES, nullable=False),
    sa.Column("content", TEXT, nullable=True),  # JSON with typed values; null: it stays in the cell
    sa.Column("verified", WHOLE, nullable=False),  # 0: without its row, or with a secret taken out of it
    # A link is collected once: what a second visit brings at the same place is refused by the database
    # itself.
    sa.UniqueConstraint("branch_id", "link", name="uq_plant_journal_link"),
    sa.Index("ix_plant_journal_stream", "branch_id", "stream", "link"),
    sa.Index("ix_plant_journal_record", "branch_id", "record", "record_id"),
)

plant_sessions = records(
    "plant_sessions",  # the newest of a session counts
    reference("branch_id", "plant_branches"),
    sa.Column("session_id", WHOLE, nullable=False),
    sa.Column("robot", TEXT, nullable=False),
    sa.Column("robot_serial_number", TEXT, nullable=False),  # empty where nobody said it; so below
    sa.Column("instrument_serial_number", TEXT, nullable=False),
    sa.Index("ix_plant_sessions_session_id", "branch_id", "session_id", "id"),
)

plant_days = records(
    "plant_days",  # readings of a session in a page that was collected
    reference("branch_id", "plant_branches"),
    sa.Column("session_id", WHOLE, nullable=False),
    sa.Column("measured_on", TEXT, nullable=False),  # by the cell's clock
    sa.Column("robot_serial_number", TEXT, nullable=False),
    sa.Column("instrument_serial_number", TEXT, nullable=False),
    sa.Column("readings", WHOLE, nullable=False),
    sa.Index("ix_plant_days_session_id", "branch_id", "session_id"),
    sa.Index("ix_plant_days_robot", "robot_serial_number", "measured_on"),
    sa.Index("ix_plant_days_instrument", "instrument_serial_number", "measured_on"),
)

plant_results = records(
    "plant_results",
    reference("branch_id", "plant_branches"),
    sa.Column("kind", TEXT, nullable=False),
    sa.Column("link", WHOLE, nullable=False),
    sa.Column("record_id", WHOLE, nullable=False),  # its number in the cell
    sa.Column("name", TEXT, nullable=False),
    sa.Column("robot", TEXT, nullable=False),
    sa.Column("robot_serial_number", TEXT, nullable=False),
    sa.Column("instrument_serial_number", TEXT, nullable=False),
    sa.Column("measured_on", TEXT, nullable=False),  # a day; empty where nobody said it
    sa.Column("clock_offset_s", REAL, nullable=True),  # when it was collected
    sa.UniqueConstraint("branch_id", "kind", "record_id", name="uq_plant_results_record"),
    sa.Index("ix_plant_results_kind", "kind", "id"),
    sa.Index("ix_plant_results_robot", "robot_serial_number", "measured_on", "id"),
    sa.Index("ix_plant_results_instrument", "instrument_serial_number", "measured_on", "id"),
)

plant_told = records(
    "plant_told",  # what a session, a result or a model tells, each once
    reference("branch_id", "plant_branches"),
    sa.Column("kind", TEXT, nullable=False),
    sa.Column("link", WHOLE, nullable=False),
    sa.Column("record_id", WHOLE, nullable=False),  # its number in the cell
    sa.Column("robot_serial_number", TEXT, nullable=False),  # empty where nobody said it
    sa.Column("measured_on", TEXT, nullable=False),  # a day; empty where nobody said it
    sa.Column("verdict", TEXT, nullable=False),  # empty: it judges nothing
    sa.Column("figure_mm", REAL, nullable=True),
    sa.Column("limit_mm", REAL, nullable=True),  # that the figure is judged by
    sa.Column("document", DOCUMENT, nullable=False),
    sa.UniqueConstraint("branch_id", "link", name="uq_plant_told_link"),
    sa.Index("ix_plant_told_robot", "robot_serial_number", "kind", "measured_on", "id"),
    sa.Index("ix_plant_told_record", "branch_id", "kind", "record_id"),
)

plant_certificates = records(
    "plant_certificates",  # where a cell states another one than before; the newest counts
    reference("branch_id", "plant_branches"),
    sa.Column("link", WHOLE, nullable=False),
    sa.Column("what", TEXT, nullable=False),
    sa.Column(
        "serial_number", TEXT, nullable=False
    ),  # empty: nobody said it, and it counts in its cell alone
    sa.Column("certificate", TEXT, nullable=False),  # empty: the cell states none any more
    sa.Column("expires", TEXT, nullable=False),  # a day; empty where nobody said it
    sa.Column("stated_on", TEXT, nullable=False),
    sa.Index("ix_plant_certificates_of", "serial_number", "branch_id", "what", "id"),
)

plant_robots = records(
    "plant_robots",
    sa.Column("serial_number", TEXT, nullable=False, unique=True),
    sa.Column("robot", TEXT, nullable=False),
)

plant_instruments = records(
    "plant_instruments", sa.Column("serial_number", TEXT, nullable=False, unique=True)
)

plant_hand_downs = records(
    "plant_hand_downs",
    reference("cell_id", "plant_cells"),
    sa.Column("kind", TEXT, nullable=False),
    sa.Column("name", TEXT, nullable=False),
    sa.Column("person", TEXT, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),
    sa.Index("ix_plant_hand_downs_cell_id", "cell_id", "id"),
)

plant_hand_down_states = records(
    "plant_hand_down_states",  # the newest counts; none: it waits for the next visit
    reference("hand_down_id", "plant_hand_downs"),
    sa.Column("state", TEXT, nullable=False),
    sa.Column("sentence", TEXT, nullable=False),
    sa.Column("number_in_cell", WHOLE, nullable=True),
    sa.Index("ix_plant_hand_down_states_hand_down_id", "hand_down_id", "id"),
)
