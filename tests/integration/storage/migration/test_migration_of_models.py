"""Models get a second origin without losing a row, a number or a reference, up and down again."""

import pytest
from alembic import command
from sqlalchemy import create_engine, event

from truepose.storage.connection.migrating import migration_config
from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.database import Database

AT = "2026-03-03T10:00:00.000+00:00"
ROWS = {
    "campaigns": [(1, AT, "spring", "arm", "{}", "[]", b"zip")],
    "jobs": [(1, AT, "identification", "{}"), (2, AT, "validation", "{}")],
    "identifications": [(1, AT, 1, 1, "{}"), (2, AT, 1, 1, "{}")],
    "models": [(4, AT, 1, "arm", '{"a": 1}'), (7, AT, 2, "arm", '{"a": 2}')],
    "validations": [(1, AT, 2, 7, 1, "{}")],
}
ROWS_AS_NOW = {
    **ROWS,
    "campaigns": [(*campaign, None) for campaign in ROWS["campaigns"]],
    "models": [(number, at, origin, None, *rest, None, None) for number, at, origin, *rest in ROWS["models"]],
}
OF_A_DIAGNOSIS = {
    "jobs": [(3, AT, "diagnosis", "{}"), (4, AT, "validation", "{}")],
    "job_states": [(1, AT, 3, "succeeded", "found", 1)],
    "events": [(1, AT, "job.state", None, 3, "{}")],
    "request_keys": [("k", AT, "f", "diagnosis job", 3)],
    "diagnoses": [(1, AT, 3, 1, AT, "", "{}", "{}")],
    "models": [(8, AT, None, 1, "arm", '{"a": 3}', None, None)],
    "validations": [(2, AT, 4, 8, 1, "{}")],
}


@pytest.fixture
def file(tmp_path):
    return tmp_path / "truepose.sqlite3"


def migrate(file, revision, *, up):
    """As the service does: one transaction, references checked."""
    engine = create_engine(f"sqlite:///{file}")
    event.listen(engine, "connect", lambda connection, _: connection.execute("PRAGMA foreign_keys=ON"))
    config = migration_config()
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        (command.upgrade if up else command.downgrade)(config, revision)
    engine.dispose()


def insert(file, rows):
    with LIBRARY.connect(file) as connection:
        for table, values in rows.items():
            marks = ", ".join("?" * len(values[0]))
            connection.executemany(f"INSERT INTO {table} VALUES ({marks})", values)
    connection.close()


def ask(file, query):
    with LIBRARY.connect(file) as connection:
        found = connection.execute(query).fetchall()
    connection.close()
    return found


def test_older_models_keep_their_numbers_and_their_validations(file):
    migrate(file, "0003", up=True)
    insert(file, ROWS)

    Database(f"sqlite:///{file}").close()

    models = ask(file, "SELECT id, identification_id, diagnosis_id, document FROM models")
    assert models == [(4, 1, None, '{"a": 1}'), (7, 2, None, '{"a": 2}')]
    assert ask(file, "SELECT model_id FROM validations") == [(7,)]
    assert ask(file, "PRAGMA foreign_key_check") == []
    assert ask(file, "SELECT seq FROM sqlite_sequence WHERE name = 'models'") == [(7,)]
    assert ask(file, "SELECT name FROM sqlite_master WHERE name = 'models_before'") == []


@pytest.mark.parametrize("origins", [(None, None, None), (1, 1, None), (1, None, 1)])
def test_a_model_has_one_origin(file, origins):
    migrate(file, "head", up=True)
    insert(file, ROWS_AS_NOW)

    with pytest.raises(LIBRARY.IntegrityError, match="CHECK"):
        insert(file, {"models": [(9, AT, *origins[:2], "arm", "{}", origins[2], None)]})


def test_on_the_way_down_diagnoses_go_with_everything_made_of_them(file):
    migrate(file, "head", up=True)
    insert(file, ROWS_AS_NOW)
    insert(file, OF_A_DIAGNOSIS)

    migrate(file, "0003", up=False)

    assert ask(file, "SELECT id, identification_id FROM models") == [(4, 1), (7, 2)]
    assert ask(file, "SELECT id FROM validations") == [(1,)]
    assert ask(file, "SELECT DISTINCT kind FROM jobs") == [("identification",), ("validation",)]
    assert ask(file, "SELECT * FROM request_keys UNION SELECT id, 0, 0, 0, 0 FROM events") == []
    assert ask(file, "PRAGMA foreign_key_check") == []


def test_on_the_way_down_accepted_models_go_with_everything_made_of_them(file):
    migrate(file, "head", up=True)
    insert(file, ROWS_AS_NOW)
    handed_down = [(1, AT, "plant", "model", "arm", "Ada Byron", "{}")]
    accepted = [(8, AT, None, None, "arm", "{}", 1, "Grace Hopper")]
    insert(file, {"handed_down": handed_down, "models": accepted, "validations": [(2, AT, 2, 8, 1, "{}")]})

    migrate(file, "0013", up=False)
    Database(f"sqlite:///{file}").close()

    assert ask(file, "SELECT id FROM models") == [(4,), (7,)]
    assert ask(file, "SELECT id FROM validations") == [(1,)]
    assert ask(file, "PRAGMA foreign_key_check") == []
