"""What a run says at its end about a machine that lacks something, and where it writes its files."""

import os
from types import SimpleNamespace

import pytest

from tests.helpers.machine import (
    CHROMIUM,
    FOLDERS_IN_MEMORY,
    MEASURED_DATA,
    folder_in_memory,
    what_was_untested,
)


def test_a_machine_that_has_everything_says_nothing():
    assert what_was_untested([]) == ""


def test_what_was_skipped_for_other_reasons_is_not_told():
    assert what_was_untested(["Skipped: a bridge knows three signals and no reasons"]) == ""


def test_a_bare_machine_says_in_one_line_what_it_could_not_test():
    skipped = [f"Skipped: {MEASURED_DATA.reason}"] * 31 + [f"Skipped: {CHROMIUM.reason}"]

    line = what_was_untested(skipped)

    assert line == (
        "Not tested on this machine: campaigns that were measured (TRUEPOSE_DATA does not name the folder of "
        "example campaigns; 31 skipped), pages in a browser (no Chromium is installed here; 1 skipped)."
    )


@FOLDERS_IN_MEMORY
@pytest.mark.parametrize(
    ("free_bytes", "flags", "there"),
    [(8 * 2**30, 0, True), (64 * 2**20, 0, False), (8 * 2**30, getattr(os, "ST_NOEXEC", 8), False)],
)
def test_files_are_in_memory_where_there_is_room_and_programs_may_run(
    monkeypatch, tmp_path, free_bytes, flags, there
):
    found = SimpleNamespace(f_bavail=free_bytes // 4096, f_frsize=4096, f_flag=flags)
    monkeypatch.setattr(os, "statvfs", lambda folder: found)

    assert (folder_in_memory(tmp_path) == tmp_path) is there


def test_without_such_a_folder_files_are_on_the_disk(tmp_path):
    assert folder_in_memory(tmp_path / "none") is None


def test_a_system_that_says_nothing_of_free_room_has_its_files_on_the_disk(monkeypatch, tmp_path):
    monkeypatch.delattr(os, "statvfs", raising=False)

    assert folder_in_memory(tmp_path) is None
