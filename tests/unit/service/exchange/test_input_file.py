"""A file that a user names is a file: nothing that waits, nothing without an end."""

import os
import socket

import pytest

from tests.helpers.machine import DEVICE_FILES, NAMED_PIPES, UNIX_SOCKETS
from truepose.exchange.document import read_bytes
from truepose.exchange.errors import BadValueError, MissingFileError, UnreadableFileError


def fifo(folder):
    os.mkfifo(folder / "it")


def listener(folder):
    with socket.socket(socket.AF_UNIX) as opened:
        opened.bind(str(folder / "it"))


def device(folder):
    (folder / "it").symlink_to("/dev/zero")


def directory(folder):
    (folder / "it").mkdir()


@pytest.mark.parametrize(
    ("make", "kind"),
    [
        pytest.param(fifo, "a pipe", marks=NAMED_PIPES),
        pytest.param(listener, "a socket", marks=UNIX_SOCKETS),
        pytest.param(device, "a device", marks=DEVICE_FILES),
        (directory, "a folder"),
    ],
)
def test_what_is_no_file_is_refused_at_once(tmp_path, make, kind):
    make(tmp_path)

    with pytest.raises(UnreadableFileError, match=f"it: this is {kind}, not a file; name a file"):
        read_bytes(tmp_path / "it")


def test_a_link_to_a_file_is_one(tmp_path):
    (tmp_path / "file").write_bytes(b"content")
    (tmp_path / "it").symlink_to(tmp_path / "file")

    assert read_bytes(tmp_path / "it") == b"content"


def test_a_file_that_is_too_large_is_refused(tmp_path):
    (tmp_path / "it").write_bytes(b"x" * (2**20 + 1))

    with pytest.raises(UnreadableFileError, match="more than 1 MB, which is the limit"):
        read_bytes(tmp_path / "it", most=2**20)


def test_a_link_that_leads_in_a_circle_is_refused(tmp_path):
    (tmp_path / "it").symlink_to(tmp_path / "it")

    with pytest.raises(UnreadableFileError, match="cannot be read"):
        read_bytes(tmp_path / "it")


@pytest.mark.parametrize("name", ["nothing", "nothing/at/all"])
def test_a_file_that_is_not_there_is_missing(tmp_path, name):
    with pytest.raises(MissingFileError, match="there is no such file"):
        read_bytes(tmp_path / name)


def test_what_a_stranger_wrote_stands_on_one_line_and_is_cut_in_its_middle():
    error = BadValueError(f"{'x' * 9000}\n is none; write one", file="a\nb", line=7, key="k" * 9000)

    assert str(error).startswith("a b, line 7, key kkk")
    assert str(error).endswith("  is none; write one.")
    assert len(str(error)) < 1500
    assert "\n" not in str(error)


def test_a_name_that_no_file_has_is_refused(tmp_path):
    with pytest.raises(UnreadableFileError, match="cannot be read"):
        read_bytes(tmp_path / "a\0b")
