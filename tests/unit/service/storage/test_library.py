"""Which versions of SQLite may corrupt a database when they reset the write-ahead log."""

import pytest

from truepose.storage.engine.sqlite_connections import has_wal_reset_fault

FAULTY = [(3, 7, 0), (3, 40, 1), (3, 44, 5), (3, 46, 1), (3, 50, 6), (3, 51, 0), (3, 51, 2)]
WHOLE = [(3, 6, 23), (3, 44, 6), (3, 44, 7), (3, 50, 7), (3, 51, 3), (3, 52, 0), (3, 53, 4)]


@pytest.mark.parametrize("version", FAULTY + WHOLE)
def test_a_version_with_the_fault_is_known(version):
    assert has_wal_reset_fault(version) == (version in FAULTY)
