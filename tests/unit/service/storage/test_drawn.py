"""What was drawn, on the disk: kept within bounds, never half, and missed by nobody when it is gone."""

import os
import shutil

import pytest

from truepose.storage.caches import DrawnFolder, rendered_page

PAGE = rendered_page(b"<svg/>")


@pytest.fixture
def folder(tmp_path):
    return DrawnFolder(tmp_path / "drawn", room_bytes=0)


def files(tmp_path):
    return sorted((tmp_path / "drawn").iterdir())


def test_what_was_drawn_of_one_thing_is_not_that_of_another(folder):
    folder.keep("model 1", PAGE)

    assert folder.get("model 1") == PAGE
    assert folder.get("model 2") is None


def test_another_service_finds_it_and_a_folder_that_was_thrown_away_is_missed_by_nobody(folder, tmp_path):
    folder.keep("model 1", PAGE)
    found = DrawnFolder(tmp_path / "drawn").get("model 1")
    shutil.rmtree(tmp_path / "drawn")

    assert found == PAGE
    assert folder.get("model 1") is None
    folder.keep("model 1", PAGE)
    assert folder.get("model 1") == PAGE


@pytest.mark.parametrize("left", [b"", b"short", None])
def test_a_file_that_was_cut_short_or_changed_is_none(folder, tmp_path, left):
    folder.keep("model 1", PAGE)
    (file,) = files(tmp_path)
    file.write_bytes(file.read_bytes()[:-1] if left is None else left)

    assert folder.get("model 1") is None


def test_what_nobody_looked_at_for_longest_makes_room(tmp_path):
    folder = DrawnFolder(tmp_path / "drawn", most_bytes=3 * 132, room_bytes=0)
    for number in range(3):
        folder.keep(f"model {number}", rendered_page(bytes(100)))
        os.utime(files(tmp_path)[0].parent / _name(folder, number), (number, number))
    folder.get("model 0")

    folder.keep("model 3", rendered_page(bytes(100)))

    assert [folder.get(f"model {number}") is not None for number in range(4)] == [True, False, True, True]


def _name(folder, number):
    return folder._file(f"model {number}").name


def test_a_disk_that_is_nearly_full_gets_nothing(tmp_path):
    folder = DrawnFolder(tmp_path / "drawn", room_bytes=2**62)

    folder.keep("model 1", PAGE)

    assert folder.get("model 1") is None
    assert files(tmp_path) == []


def test_a_disk_that_refuses_costs_a_drawing_and_no_error(tmp_path):
    (tmp_path / "drawn").write_text("no folder")
    folder = DrawnFolder(tmp_path / "drawn", room_bytes=0)

    folder.keep("model 1", PAGE)

    assert folder.get("model 1") is None
