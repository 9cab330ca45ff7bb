"""The ledger of ballbar sessions comes to older databases, and goes again with its sessions."""

from tests.integration.storage.migration.test_migration_of_models import AT, ask, insert, migrate

OLDER = {
    "sessions": [(1, AT, "spring", "calibration", "{}", "{}")],
    "session_states": [(1, AT, 1, "planned", "", None)],
    "events": [(1, AT, "session.state", 1, None, "{}")],
    "request_keys": [("a", AT, "f", "session", 1)],
}
NEWER = {
    "sessions": [(2, AT, "six legs", "ballbar", "{}", "{}")],
    "session_states": [(2, AT, 2, "planned", "", None)],
    "events": [(2, AT, "session.entry", 2, None, "{}")],
    "notes": [(1, AT, 2, "looked")],
    "request_keys": [("b", AT, "f", "session", 2)],
    "ballbar_entries": [(1, AT, 2, "tool/initialise", "measured", "k", "{}")],
    "ballbar_answers": [(1, AT, 2, 1, "k", "f", "stored")],
}


def test_an_older_database_keeps_its_sessions(tmp_path):
    file = tmp_path / "truepose.sqlite3"
    migrate(file, "0005", up=True)
    insert(file, OLDER)

    migrate(file, "0006", up=True)
    insert(file, NEWER)

    assert ask(file, "SELECT id, role FROM sessions") == [(1, "calibration"), (2, "ballbar")]
    assert ask(file, "PRAGMA foreign_key_check") == []


def test_on_the_way_down_ballbar_sessions_go_with_everything_of_them(tmp_path):
    file = tmp_path / "truepose.sqlite3"
    migrate(file, "0006", up=True)
    insert(file, OLDER)
    insert(file, NEWER)

    migrate(file, "0005", up=False)

    assert ask(file, "SELECT id FROM sessions") == [(1,)]
    assert ask(file, "SELECT session_id FROM session_states") == [(1,)]
    assert ask(file, "SELECT session_id FROM events") == [(1,)]
    assert ask(file, "SELECT key FROM request_keys") == [("a",)]
    assert ask(file, "SELECT id FROM notes") == []
    assert ask(file, "SELECT name FROM sqlite_master WHERE name LIKE 'ballbar%'") == []
    assert ask(file, "PRAGMA foreign_key_check") == []
