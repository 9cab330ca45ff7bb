"""Fixtures that several folders use."""

import asyncio
import gc
import os
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tests.helpers.machine import MEASURED_DATA, PANGO, folder_in_memory, what_was_untested
from tests.helpers.order import spread, turned
from tests.helpers.web.pages import leave_pictures_empty
from truepose_drivers.contract.case import SimulatedTimeLoop

_TESTS = Path(__file__).parent
_OBJECTS_BETWEEN_SEARCHES = 50_000

# How long an example takes says how busy the machine is, not whether the code is right.
settings.register_profile("any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("any machine")


def pytest_configure():
    """Write files to memory, and spare every process a search through all packages."""
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")  # to find none takes a look at every package
    memory = folder_in_memory()
    if memory is not None and "TMPDIR" not in os.environ:  # whoever names a folder gets it
        os.environ["TMPDIR"] = tempfile.tempdir = str(memory)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """Let each process begin with other files, so that none compiles what another has compiled."""
    report = yield
    if isinstance(collector, pytest.Directory) and report.passed:
        report.result = turned(report.result, _share_before(collector.config))
    return report


def _share_before(config):
    """Return the share of the processes that come before this one; 0 where there are no others."""
    process = getattr(config, "workerinput", {"workerid": "gw0", "workercount": 1})
    return int(process["workerid"].removeprefix("gw")) / process["workercount"]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Let files that wait run beside files that compute, in the same order in every process."""
    items.sort(key=lambda item: item.path)
    ours = {item.path for item in items if item.path.is_relative_to(_TESTS)}  # not the suite of drivers
    files = {path: path.relative_to(_TESTS).as_posix() for path in sorted(ours)}
    ranks = spread(list(files.values()))
    items.sort(key=lambda item: ranks.get(files.get(item.path, ""), 0))


def pytest_asyncio_loop_factories(config, item):
    """Give a test that is marked `simulated_time` a loop that never waits."""
    if item.get_closest_marker("simulated_time"):
        return {"simulated time": SimulatedTimeLoop}
    return {"time of the wall": asyncio.new_event_loop}


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Search for no garbage while modules are imported, later seldom, and never in what collection made."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(_OBJECTS_BETWEEN_SEARCHES)
        gc.enable()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_terminal_summary(terminalreporter):
    """Say below everything else what this machine could not test."""
    shown = yield
    skipped = terminalreporter.stats.get("skipped", [])
    line = what_was_untested(str(report.longrepr) for report in skipped)
    if line:
        terminalreporter.write_line(line, yellow=True)
    return shown


@pytest.fixture(scope="session")
def measured_data() -> Path:
    """The folder of example campaigns, which is not part of the repository."""
    folder = Path(os.environ.get("TRUEPOSE_DATA", ""))
    if not (folder / "campaigns").is_dir():
        pytest.skip(MEASURED_DATA.reason)
    return folder


@pytest.fixture(scope="session")
def text_library():
    """What a PDF is set with, which the system brings or does not."""
    from truepose.reports.paper import (
        NoPdfError,  # most files print nothing
        require_pdf,
    )

    try:
        require_pdf()
    except NoPdfError:
        pytest.skip(PANGO.reason)


@pytest.fixture(scope="session")
def empty_database(tmp_path_factory) -> Path:
    """A database of the newest schema without records, to be copied.

    To make a schema anew takes longer than most tests that need one.
    """
    from truepose.storage.database import Database  # unit tests need no storage

    file = tmp_path_factory.mktemp("schema") / "truepose.sqlite3"
    Database(f"sqlite:///{file}").close()
    return file


@pytest.fixture(scope="module")
def forked_processes():
    """What is started in a file of tests is forked from a process that has everything loaded."""
    from tests.helpers.forked import everything_forked  # most files start nothing

    with everything_forked():
        yield


@pytest.fixture
def empty_pictures(monkeypatch):
    """Pictures are put together but not painted; for who reads the text."""
    leave_pictures_empty(monkeypatch)
