"""The log: JSON in a file, sentences on standard error, and nothing that holds up the service."""

import contextlib
import json
import logging
import os

import pytest

from truepose.app import logs
from truepose.app.logs import logged
from truepose.correlation import REQUEST
from truepose.web.middleware.request_log import LOGGER

LOG = logging.getLogger("truepose.somewhere")


def written(file):
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]


@pytest.fixture
def file(tmp_path):
    return tmp_path / "logs" / "cell.log"


def test_a_line_says_when_where_what_and_for_which_request(file, capsys):
    with logged(file, "INFO"):
        LOG.info("nothing has moved: %d", 7)
        before = REQUEST.set("tablet-3")
        LOG.warning("répété")
        REQUEST.reset(before)

    first, second = written(file)
    assert (first["level"], first["logger"], first["message"]) == ("info", LOG.name, "nothing has moved: 7")
    assert first["request"] is None
    assert first["time"].endswith("+00:00")
    assert (second["request"], second["message"]) == ("tablet-3", "répété")
    said = capsys.readouterr().err
    assert (
        said
        == "INFO truepose.somewhere: nothing has moved: 7\nWARNING truepose.somewhere: répété [tablet-3]\n"
    )


def test_what_is_below_the_level_is_not_written(file, capsys):
    with logged(file, "WARNING"):
        LOG.info("nothing")

    assert not file.exists()
    assert capsys.readouterr().err == ""


def test_a_traceback_is_a_field_of_its_line(file):
    with logged(file, "INFO"):
        try:
            raise ValueError("wrong")
        except ValueError:
            LOG.exception("it failed")

    (line,) = written(file)
    assert line["message"] == "it failed"
    assert "ValueError: wrong" in line["traceback"]


def test_requests_are_told_in_the_file_alone_unless_they_failed(file, capsys):
    with logged(file, "INFO"):
        logging.getLogger(LOGGER).info("get_cell: answered with 200", extra={"fields": {"status": 200}})
        logging.getLogger(LOGGER).warning("get_cell: answered with 500", extra={"fields": {"status": 500}})

    assert [line["status"] for line in written(file)] == [200, 500]
    assert capsys.readouterr().err == "WARNING truepose.requests: get_cell: answered with 500\n"


def test_a_full_disk_costs_lines_and_nothing_else(file, monkeypatch):
    full = True

    class Full(logs._File):
        def shouldRollover(self, record):  # noqa: N802
            if full:
                raise OSError(28, "No space left on device")
            return super().shouldRollover(record)

    monkeypatch.setattr(logs, "_File", Full)
    with logged(file, "INFO") as lost:
        LOG.info("lost")
        LOG.info("also lost")
        while lost.lines < 2:
            os.sched_yield()
        full = False
        LOG.info("kept")

    told, kept = (line["message"] for line in written(file))
    assert told == "2 lines before this one were not written."
    assert kept == "kept"


def test_a_folder_that_cannot_be_written_costs_lines_and_nothing_else(tmp_path, capsys):
    (tmp_path / "file").write_text("in the way")

    with logged(tmp_path / "file" / "cell.log", "INFO") as lost:
        LOG.info("read by a person at least")

    assert lost.lines == 1
    assert "read by a person at least" in capsys.readouterr().err


def test_a_queue_that_is_full_drops_lines_without_waiting(file, monkeypatch):
    monkeypatch.setattr(logs, "_WAITING", 2)
    monkeypatch.setattr(logs.QueueListener, "start", lambda self: None)
    monkeypatch.setattr(logs.QueueListener, "stop", lambda self: None)

    with logged(file, "INFO") as lost:
        for n in range(5):
            LOG.info("line %d", n)

    assert lost.lines == 3


def test_files_are_exchanged_before_they_fill_a_disk(file, monkeypatch):
    monkeypatch.setattr(logs, "_FILE_BYTES", 300)
    with logged(file, "INFO"):
        for n in range(30):
            LOG.info("line %d", n)

    assert len([*file.parent.iterdir()]) == 1 + logs._FILES
    assert sum(path.stat().st_size for path in file.parent.iterdir()) < 300 * (2 + logs._FILES)


def test_what_was_set_up_is_taken_down(file):
    everything = logging.getLogger()
    before = [*everything.handlers], everything.level

    with contextlib.suppress(KeyboardInterrupt), logged(file, "DEBUG"):
        raise KeyboardInterrupt

    assert ([*everything.handlers], everything.level) == before
