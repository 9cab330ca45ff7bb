"""The tables as the newest migration leaves them; domain classes know nothing of them.

Every table is append-only (the migrations add triggers that refuse UPDATE and DELETE): what a
record becomes is a further row. Times of day are UTC in ISO 8601; `time_s` is the cell's clock.
"""

from typing import Final

import sqlalchemy as sa

from truepose.storage.engine.dialects import (
    BYTES,
    DOCUMENT,
    REAL,
    SAID,
    TEXT,
    WHOLE,
    number,
    records,
    records_of_sessions,
    reference,
)
from truepose.storage.engine.dialects import metadata as metadata
from truepose.storage.plant.tables import plant_journal

# Of these a record may have many megabytes: each is read by itself.
LARGE: Final = frozenset({"campaigns", "corrections", "reports"})
_MIXED: Final = {plant_journal.name: 50}  # of all kinds, most of them small
_SMALL: Final = 1000
_ORIGINS: Final = ("identification", "diagnosis", "handed_down")  # of a model; it has one of them


def read_at_once(table: str) -> int:
    """Return how many records of a table are read at a time, so that they have room in memory."""
    # Whoever copies, verifies or hands on records holds so many in memory at a time.
    return 1 if table in LARGE else _MIXED.get(table, _SMALL)


sessions = records(
    "sessions",
    sa.Column("name", TEXT, nullable=False),
    sa.Column("role", TEXT, nullable=False),
    sa.Column("setup", DOCUMENT, nullable=False),
    sa.Column("plan", DOCUMENT, nullable=False),
)

session_states = records_of_sessions(
    "session_states",
    sa.Column("state", TEXT, nullable=False),
    sa.Column("reason", SAID, nullable=False),
    sa.Column("person", TEXT, nullable=True),
)

readings = records_of_sessions(
    "readings",
    sa.Column("kind", TEXT, nullable=False),  # point or fixed_nest
    sa.Column("config", WHOLE, nullable=True),
    sa.Column("nest", WHOLE, nullable=False),  # of the tool, or fixed
    sa.Column("time_s", REAL, nullable=False),
    # A reading is superseded at most once: two successors would leave two truths.
    sa.Column("supersedes", WHOLE, sa.ForeignKey("readings.id"), nullable=True, unique=True),
    sa.Column("document", DOCUMENT, nullable=False),
    # Finds what a new reading supersedes. Without it the search went through every reading of the session,
    # and a long one slowed down (commit 9f432d46).
    sa.Index("ix_readings_place", "session_id", "config", "nest", "id"),
    sa.Index("ix_readings_counted", "session_id", "kind", "supersedes"),
)

notes = records_of_sessions("notes", sa.Column("text", SAID, nullable=False))

added_stops = records_of_sessions(
    "added_stops",
    reference("diagnosis_id", "diagnoses", nullable=True),  # which is to be run again after them
    sa.Column("person", TEXT, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),
)

closings = records_of_sessions(
    "closings",
    sa.Column("closed_as", TEXT, nullable=False),
    sa.Column("person", TEXT, nullable=False),
    sa.Column("reason", TEXT, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),  # the certificates, as they stood
    sa.UniqueConstraint("session_id"),  # two closings would leave two truths
)

session_entries = records_of_sessions(
    "session_entries",
    sa.Column("step_id", TEXT, nullable=False),
    sa.Column("kind", TEXT, nullable=False),
    sa.Column("key", TEXT, nullable=True),  # of the request that caused it
    sa.Column("document", DOCUMENT, nullable=False),  # without the reading that it brings
    reference("reading_id", "readings", nullable=True),
    sa.UniqueConstraint("session_id", "key", name="uq_session_entries_key"),
    sa.Index("ix_session_entries_kind", "session_id", "kind", "step_id"),
)

act_answers = records(
    "act_answers",
    reference("session_id", "sessions"),
    reference("entry_id", "session_entries", nullable=True),  # what was kept; none: nothing was
    sa.Column("key", TEXT, nullable=False),
    sa.Column("fingerprint", TEXT, nullable=False),  # SHA-256 of method, path and body
    sa.Column("sentence", SAID, nullable=False),
    sa.UniqueConstraint("session_id", "key", name="uq_act_answers_key"),
)

series = records(
    "series",
    sa.Column("name", TEXT, nullable=False),
    sa.Column("columns", DOCUMENT, nullable=False),  # as the header of a table has them
)

deliveries = records(
    "deliveries",
    reference("series_id", "series"),
    sa.Column("first", WHOLE, nullable=False),  # number of its first reading
    sa.Column("count", WHOLE, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),
    sa.UniqueConstraint("series_id", "first"),  # a reading has one number
)

campaigns = records(
    "campaigns",
    sa.Column("name", TEXT, nullable=False),
    sa.Column("robot", TEXT, nullable=False),
    sa.Column("summary", DOCUMENT, nullable=False),
    sa.Column("session_ids", DOCUMENT, nullable=False),  # empty for an uploaded campaign
    sa.Column("archive", BYTES, nullable=False),  # zip of the folder as it came; empty: none did
    sa.Column("campaign", BYTES, nullable=False),  # packed
)

jobs = records(
    "jobs",
    sa.Column("kind", TEXT, nullable=False),
    sa.Column("request", DOCUMENT, nullable=False),
)

job_states = records(
    "job_states",
    reference("job_id", "jobs"),
    sa.Column("state", TEXT, nullable=False),
    sa.Column("message", SAID, nullable=False),
    sa.Column("result_id", WHOLE, nullable=True),  # of the kind that the job makes
    sa.Index("ix_job_states_job_id", "job_id", "id"),
)

identifications = records(
    "identifications",
    reference("job_id", "jobs"),
    reference("campaign_id", "campaigns"),
    sa.Column("document", DOCUMENT, nullable=False),
)

diagnoses = records(
    "diagnoses",
    reference("job_id", "jobs"),
    reference("campaign_id", "campaigns"),
    sa.Column("measured_at", TEXT, nullable=False),  # empty where nobody said it
    sa.Column("robot_serial_number", TEXT, nullable=False),  # empty where nobody said it
    sa.Column("summary", DOCUMENT, nullable=False),  # the document without what only a page draws
    sa.Column("document", DOCUMENT, nullable=False),
)

models = records(
    "models",
    reference("identification_id", "identifications", nullable=True),
    reference("diagnosis_id", "diagnoses", nullable=True),
    sa.Column("robot", TEXT, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),
    reference("handed_down_id", "handed_down", nullable=True),
    sa.Column("accepted_by", TEXT, nullable=True),  # of one that was handed down
    sa.Index("uq_models_handed_down_id", "handed_down_id", unique=True),
    # The sum counts the origins; both engines know CASE, and neither turns a truth value into a number as the
    # other does.
    sa.CheckConstraint(
        " + ".join(f"(CASE WHEN {origin}_id IS NULL THEN 0 ELSE 1 END)" for origin in _ORIGINS) + " = 1",
        name="models_one_origin",
    ),
)

validations = records(
    "validations",
    reference("job_id", "jobs"),
    reference("model_id", "models"),
    reference("campaign_id", "campaigns"),
    sa.Column("document", DOCUMENT, nullable=False),
)

corrections = records(
    "corrections",
    reference("job_id", "jobs"),
    reference("model_id", "models"),
    sa.Column("name", TEXT, nullable=False),  # of the file
    sa.Column("original_sha256", TEXT, nullable=False),
    sa.Column("corrected_sha256", TEXT, nullable=False),
    sa.Column("asked", DOCUMENT, nullable=False),
    sa.Column("document", DOCUMENT, nullable=False),
    sa.Column("targets", BYTES, nullable=False),  # packed
    sa.Column("file", BYTES, nullable=False),  # corrected
    sa.Index("ix_corrections_model_id", "model_id", "id"),
)

events = records(
    "events",
    sa.Column("kind", TEXT, nullable=False),
    reference("session_id", "sessions", nullable=True),
    reference("job_id", "jobs", nullable=True),
    reference("reading_id", "readings", nullable=True),  # that it tells of, and then all that it says
    sa.Column("document", DOCUMENT, nullable=False),
    sa.Index("ix_events_session_id", "session_id", "kind", "id"),
    sa.Index("ix_events_job_id", "job_id", "kind", "id"),
)

request_keys = records(
    "request_keys",
    sa.Column("key", TEXT, nullable=False, unique=True),
    sa.Column("fingerprint", TEXT, nullable=False),  # SHA-256 of method, path and body
    sa.Column("resource", TEXT, nullable=False),
    sa.Column("resource_id", WHOLE, nullable=False),
)

people = records("people", sa.Column("name", TEXT, nullable=False, unique=True))

person_states = records(
    "person_states",  # the newest counts
    reference("person_id", "people"),
    sa.Column("role", TEXT, nullable=False),
    sa.Column("active", WHOLE, nullable=False),
    sa.Column("by", TEXT, nullable=False),
)

credentials = records(
    "credentials",
    sa.Column("kind", TEXT, nullable=False),
    reference("person_id", "people", nullable=True),
    sa.Column("hash", TEXT, nullable=False),  # argon2id of what people choose, SHA-256 of what is random
    sa.Column("expires_at", TEXT, nullable=True),
    sa.Column("document", DOCUMENT, nullable=False),
)

revocations = records(
    "revocations",
    reference("credential_id", "credentials"),
    sa.Column("by", TEXT, nullable=False),
    sa.Index("ix_revocations_credential_id", "credential_id"),
)

acts = records(
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

reports = records(
    "reports",
    sa.Column("kind", TEXT, nullable=False),
    sa.Column("subject_id", WHOLE, nullable=False),  # of the result of that kind
    sa.Column("revision", WHOLE, nullable=False),
    sa.Column("language", TEXT, nullable=False),
    sa.Column("stated_sha256", TEXT, nullable=False),  # of all that it states, whatever the language
    sa.Column("page", BYTES, nullable=False),  # deflated
    sa.UniqueConstraint("kind", "subject_id", "revision", "language"),
)

handed_down = records(
    "handed_down",
    sa.Column("plant", TEXT, nullable=False),  # as its token is called
    sa.Column("kind", TEXT, nullable=False),  # plan or model
    sa.Column("name", TEXT, nullable=False),
    sa.Column("person", TEXT, nullable=False),  # who handed it down at the plant
    sa.Column("document", DOCUMENT, nullable=False),
)

hand_down_uses = records(
    "hand_down_uses",
    reference("handed_down_id", "handed_down"),
    sa.Column("person", TEXT, nullable=False),
    sa.Column("note", TEXT, nullable=False),
    sa.Index("ix_hand_down_uses_handed_down_id", "handed_down_id", "id"),
)

links = sa.Table(
    "links",
    metadata,
    number("links"),
    sa.Column("stream", WHOLE, nullable=False),  # the session, 0 for what belongs to none
    sa.Column("record", TEXT, nullable=False),  # name of its table
    sa.Column("record_id", WHOLE, nullable=False),
    sa.Column("hash", BYTES, nullable=False),  # over the record and the hash before in its stream
    sa.Index("ix_links_stream", "stream", "id"),
    sqlite_autoincrement=True,
)
