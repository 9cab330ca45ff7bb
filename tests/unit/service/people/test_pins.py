"""A PIN is found by nobody who has the database alone, and counts where its secret is."""

import os
import secrets
import stat

import pytest

from tests.helpers.machine import POSIX_MODES
from truepose.people.secrets import Pins, matches
from truepose.storage.errors import StorageUnavailableError
from truepose.storage.secret_files import Pepper


@pytest.fixture
def pepper(tmp_path):
    return Pepper.beside(tmp_path / "truepose.sqlite3")


def test_whoever_has_the_database_alone_finds_no_pin_by_trying(pepper):
    kept = Pins(pepper).kept("4071")

    hashed = kept[kept.index("$") :]
    assert not any(matches(hashed, f"{pin:04}") for pin in range(4060, 4080))
    assert Pins(pepper).match(kept, "4071")
    assert not Pins(pepper).match(kept, "4072")


def test_a_pin_counts_where_its_secret_is_and_nowhere_else(pepper, tmp_path):
    kept = Pins(pepper).kept("4071")
    again, elsewhere = Pins(Pepper(pepper.file)), Pins(Pepper(tmp_path / "other.pins"))
    nothing = elsewhere.counts(kept)
    elsewhere.kept("4071")

    assert (again.counts(kept), again.match(kept, "4071")) == (True, True)
    assert (nothing, elsewhere.counts(kept), elsewhere.match(kept, "4071")) == (False, False, False)
    assert not again.counts("taken out")
    assert not again.match("taken out", "4071")


@POSIX_MODES
def test_the_secret_is_its_owners_alone_whatever_the_umask(pepper):
    before = os.umask(0)
    try:
        Pins(pepper).kept("4071")
        made = stat.S_IMODE(pepper.file.stat().st_mode)
        pepper.file.chmod(0o644)
        Pepper(pepper.file).key()
    finally:
        os.umask(before)

    assert (made, stat.S_IMODE(pepper.file.stat().st_mode)) == (0o600, 0o600)


def test_a_secret_gets_its_place_whole_or_not_at_all(pepper, monkeypatch):
    def power_cut(*of):
        raise OSError(5, "Input/output error")

    with monkeypatch.context() as cut:
        cut.setattr(os, "fsync", power_cut)
        with pytest.raises(StorageUnavailableError):
            Pins(pepper).kept("4071")
    assert not pepper.file.exists()

    assert Pins(pepper).match(Pins(pepper).kept("4071"), "4071")


def test_a_secret_that_another_process_made_meanwhile_stays(pepper, monkeypatch):
    drawn = secrets.token_hex

    def drawn_while_another_writes(count):
        pepper.file.write_text("1" * 64)
        return drawn(count)

    monkeypatch.setattr(secrets, "token_hex", drawn_while_another_writes)

    with pytest.raises(StorageUnavailableError):
        Pins(pepper).kept("4071")

    assert pepper.file.read_text() == "1" * 64


@pytest.mark.parametrize("text", ["", "secret", "0" * 63, "\u00e9"])
def test_a_secret_that_is_none_is_one_sentence(pepper, text):
    pepper.file.write_text(text, encoding="utf-8")

    with pytest.raises(StorageUnavailableError, match=r"The secret of the PINs, .*\.pins, cannot be used"):
        Pins(pepper).kept("4071")
