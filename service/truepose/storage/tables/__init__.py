"""The tables as the newest migration leaves them; domain classes know nothing of them.

Every table is append-only (the migrations add triggers that refuse UPDATE and DELETE): what a
record becomes is a further row. Times of day are UTC in ISO 8601; `time_s` is the cell's clock.
"""

from typing import Final

import sqlalchemy as sa

from truepose.storage.column_types import BYTES, DOCUMENT, REAL, TEXT, WHOLE
from truepose.storage.tables import of_plants
from truepose.storage.tables.forms import metadata as metadata
from truepose.storage.tables.forms import number as _number
from truepose.storage.tables.forms import recorded as _recorded
from truepose.storage.tables.forms import records as _records
from truepose.storage.tables.forms import records_of_sessions as _records_of_sessions
from truepose.storage.tables.forms import reference as _reference

# Of these a record may have many megabytes: each is read by itself.
LARGE: Final = frozenset({"campaigns", "corrections", "reports"})
_MIXED: Final = {of_plants.plant_journal.name: 50}  # of all kinds, most of them small
_SMALL: Final = 1000


def read_at_once(table: str) -> int:
    """Return how many records of a table are read at a time, so that they have room in memory."""
    return 1 if table in LARGE else _MIXED.get(table, _SMALL)


sessions = _records(
    "sessions",
    sa.Column("name", TEXT, nullable=False),
    sa.Column("role", TEXT, nullable=False),
    sa.Column("setup", DOCUMENT, nullable=False),
    sa.Column("plan", DOCUMENT, nullable=False),
)

session_states = _records_of_sessions(
    "session_states",
    sa.Column("state", TEXT, nullable=False),
    sa.Column("reason", TEXT, nullable=False),
    sa.Column("person", TEXT, nullable=True),
)

readings = _records_of_sessions(
    "readings",
    sa.Column("kind", TEXT, nullable=False),  # point or fixed_nest
    sa.Column("config", WHOLE, nullable=True),
    sa.Column("nest", WHOLE, nullable=False),  # of the tool, or fixed
    sa.Column("time_s", REAL, nullable=False),
    # A reading is superseded at most once: two successors would leave two truths.
    sa.Column("supersedes", WHOLE, sa.ForeignKey("readings.id"), nullable=True, unique=True),
    sa.Column("document", DOCUMENT, nullable=False),
    sa.Index("ix_readings_place", "session_id", "config", "nest", "id"),
    sa.Index("ix_readings_counted", "session_id", "kind", "supersedes"),
)

skipped_stops = _records_of_sessions("skipped_stops", sa.Column("document", DOCUMENT, nullable=False))

registrations = _records_of_sessions("registrations", sa.Column("document", DOCUMENT, nullable=False))

notes = _records_of_sessions("notes", sa.Column("text", TEXT, nullable=False))

added_stops = _records_of_sessions(
    "added_stops",
    _reference("diagnosis_id", "diagnoses", nullable=True),  # which is to be run again after them
    sa.Column("person", TEXT, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),
)

closings = _records_of_sessions(
    "closings",
    sa.Column("closed_as", TEXT, nullable=False),
    sa.Column("person", TEXT, nullable=False),
    sa.Column("reason", TEXT, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),  # the certificates, as they stood
    sa.UniqueConstraint("session_id"),  # two closings would leave two truths
)

session_entries = _records_of_sessions(
    "session_entries",
    sa.Column("step_id", TEXT, nullable=False),
    sa.Column("kind", TEXT, nullable=False),
    sa.Column("key", TEXT, nullable=True),  # of the request that caused it
    sa.Column("document", DOCUMENT, nullable=False),  # without the reading that it brings
    _reference("reading_id", "readings", nullable=True),
    sa.UniqueConstraint("session_id", "key", name="uq_ballbar_entries_key"),
    sa.Index("ix_session_entries_kind", "session_id", "kind", "step_id"),
)

ballbar_answers = _records(
    "ballbar_answers",
    _reference("session_id", "sessions"),
    _reference("entry_id", "session_entries", nullable=True),  # what was kept; none: nothing was
    sa.Column("key", TEXT, nullable=False),
    sa.Column("fingerprint", TEXT, nullable=False),  # SHA-256 of method, path and body
    sa.Column("sentence", TEXT, nullable=False),
    sa.UniqueConstraint("session_id", "key", name="uq_ballbar_answers_key"),
)

series = _records(
    "series",
    sa.Column("name", TEXT, nullable=False),
    sa.Column("columns", DOCUMENT, nullable=False),  # as the header of a table has them
)

deliveries = _records(
    "deliveries",
    _reference("series_id", "series"),
    sa.Column("first", WHOLE, nullable=False),  # number of its first reading
    sa.Column("count", WHOLE, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),
    sa.UniqueConstraint("series_id", "first"),  # a reading has one number
)

campaigns = _records(
    "campaigns",
    sa.Column("name", TEXT, nullable=False),
    sa.Column("robot", TEXT, nullable=False),
    sa.Column("summary", DOCUMENT, nullable=False),
    sa.Column("session_ids", DOCUMENT, nullable=False),  # empty for an uploaded campaign
    sa.Column("archive", BYTES, nullable=False),  # zip of the folder as it came; empty: none did
    sa.Column("campaign", BYTES, nullable=True),  # packed; null in rows of before: see the archive
)

jobs = _records(
    "jobs",
    sa.Column("kind", TEXT, nullable=False),
    sa.Column("request", DOCUMENT, nullable=False),
)

job_states = _records(
    "job_states",
    _reference("job_id", "jobs"),
    sa.Column("state", TEXT, nullable=False),
    sa.Column("message", TEXT, nullable=False),
    sa.Column("result_id", WHOLE, nullable=True),  # of the kind that the job makes
    sa.Index("ix_job_states_job_id", "job_id", "id"),
)

identifications = _records(
    "identifications",
    _reference("job_id", "jobs"),
    _reference("campaign_id", "campaigns"),
    sa.Column("document", DOCUMENT, nullable=False),
)

diagnoses = _records(
    "diagnoses",
    _reference("job_id", "jobs"),
    _reference("campaign_id", "campaigns"),
    sa.Column("measured_at", TEXT, nullable=False),  # empty where nobody said it
    sa.Column("robot_serial_number", TEXT, nullable=False),  # empty where nobody said it
    sa.Column("summary", DOCUMENT, nullable=False),  # the document without what only a page draws
    sa.Column("document", DOCUMENT, nullable=False),
)

models = _records(
    "models",
    # exactly one of identification, diagnosis and what a plant handed down
    _reference("identification_id", "identifications", nullable=True),
    _reference("diagnosis_id", "diagnoses", nullable=True),
    sa.Column("robot", TEXT, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),
    _reference("handed_down_id", "handed_down", nullable=True),
    sa.Column("accepted_by", TEXT, nullable=True),  # of one that was handed down
    sa.Index("uq_models_handed_down_id", "handed_down_id", unique=True),
)

validations = _records(
    "validations",
    _reference("job_id", "jobs"),
    _reference("model_id", "models"),
    _reference("campaign_id", "campaigns"),
    sa.Column("document", DOCUMENT, nullable=False),
)

corrections = _records(
    "corrections",
    _reference("job_id", "jobs"),
    _reference("model_id", "models"),
    sa.Column("name", TEXT, nullable=False),  # of the file
    sa.Column("original_sha256", TEXT, nullable=False),
    sa.Column("corrected_sha256", TEXT, nullable=False),
    sa.Column("asked", DOCUMENT, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),
    sa.Column("targets", BYTES, nullable=False),  # packed
    sa.Column("file", BYTES, nullable=False),  # corrected
    sa.Index("ix_corrections_model_id", "model_id", "id"),
)

events = _records(
    "events",
    sa.Column("kind", TEXT, nullable=False),
    _reference("session_id", "sessions", nullable=True),
    _reference("job_id", "jobs", nullable=True),
    sa.Column("document", DOCUMENT, nullable=False),
    sa.Index("ix_events_session_id", "session_id", "kind", "id"),
    sa.Index("ix_events_job_id", "job_id", "kind", "id"),
)

request_keys = sa.Table(
    "request_keys",
    metadata,
    sa.Column("key", TEXT, primary_key=True),
    _recorded(),
    sa.Column("fingerprint", TEXT, nullable=False),  # SHA-256 of method, path and body
    sa.Column("resource", TEXT, nullable=False),
    sa.Column("resource_id", WHOLE, nullable=False),
)

people = _records("people", sa.Column("name", TEXT, nullable=False, unique=True))

person_states = _records(
    "person_states",  # the newest counts
    _reference("person_id", "people"),
    sa.Column("role", TEXT, nullable=False),
    sa.Column("active", WHOLE, nullable=False),
    sa.Column("by", TEXT, nullable=False),
)

credentials = _records(
    "credentials",
    sa.Column("kind", TEXT, nullable=False),
    _reference("person_id", "people", nullable=True),
    sa.Column("hash", TEXT, nullable=False),  # argon2id of what people choose, SHA-256 of what is random
    sa.Column("expires_at", TEXT, nullable=True),
    sa.Column("document", DOCUMENT, nullable=False),
)

revocations = _records(
    "revocations",
    _reference("credential_id", "credentials"),
    sa.Column("by", TEXT, nullable=False),
    sa.Index("ix_revocations_credential_id", "credential_id"),
)

acts = _records(
    "acts",
    sa.Column("happened_at", TEXT, nullable=False),
    sa.Column("operation", TEXT, nullable=False),
    sa.Column("resource", TEXT, nullable=False),
    sa.Column("status", WHOLE, nullable=False),
    sa.Column("person", TEXT, nullable=True),
    sa.Column("role", TEXT, nullable=True),
    sa.Column("how", TEXT, nullable=True),
    sa.Column("tablet", TEXT, nullable=True),
    sa.Column("address", TEXT, nullable=True),
    sa.Column("reason", TEXT, nullable=True),
)

reports = _records(
    "reports",
    sa.Column("kind", TEXT, nullable=False),
    sa.Column("subject_id", WHOLE, nullable=False),  # of the result of that kind
    sa.Column("revision", WHOLE, nullable=False),
    sa.Column("language", TEXT, nullable=False),
    sa.Column("stated_sha256", TEXT, nullable=False),  # of all that it states, whatever the language
    sa.Column("page", BYTES, nullable=False),  # deflated
    sa.UniqueConstraint("kind", "subject_id", "revision", "language"),
)

handed_down = _records(
    "handed_down",
    sa.Column("plant", TEXT, nullable=False),  # as its token is called
    sa.Column("kind", TEXT, nullable=False),  # plan or model
    sa.Column("name", TEXT, nullable=False),
    sa.Column("person", TEXT, nullable=False),  # who handed it down at the plant
    sa.Column("document", DOCUMENT, nullable=False),
)

hand_down_uses = _records(
    "hand_down_uses",
    _reference("handed_down_id", "handed_down"),
    sa.Column("person", TEXT, nullable=False),
    sa.Column("note", TEXT, nullable=False),
    sa.Index("ix_hand_down_uses_handed_down_id", "handed_down_id", "id"),
)

TABLES_OF_PLANTS = of_plants  # among the same metadata, whoever imports this module

links = sa.Table(
    "links",
    metadata,
    _number("links"),
    sa.Column("stream", WHOLE, nullable=False),  # the session, 0 for what belongs to none
    sa.Column("record", TEXT, nullable=False),  # name of its table
    sa.Column("record_id", WHOLE, nullable=False),
    sa.Column("hash", BYTES, nullable=False),  # over the record and the hash before in its stream
    sa.Index("ix_links_stream", "stream", "id"),
    sqlite_autoincrement=True,
)
