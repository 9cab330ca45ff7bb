"""Which functions of the product the tests of a file run: `pytest -p tests.studies.mutants.functions`."""

import gc
import json
import sys
import threading
from collections import defaultdict
from contextlib import contextmanager
from functools import _lru_cache_wrapper
from pathlib import Path

import pytest

RAN = Path("functions.json")  # files of tests, by file and line of the function

_ran: dict[str, set[str]] = defaultdict(set)
_files: list[Path] = []


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """Note what runs while a file of tests is imported: tables of its tests are made then."""
    with _noted_for(collector.path):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Note what runs during a test; what helpers remember is forgotten from file to file."""
    if _files[-1:] != [item.path]:
        _files.append(item.path)
        for one in gc.get_objects():
            if isinstance(one, _lru_cache_wrapper):
                one.cache_clear()
    with _noted_for(item.path):
        return (yield)


@contextmanager
def _noted_for(file: Path):
    codes = set()

    def note(frame, _event, _argument):
        codes.add(frame.f_code)

    threading.settrace(note)
    sys.settrace(note)
    try:
        yield
    finally:
        sys.settrace(None)
        threading.settrace(None)
        for code in codes:
            _ran[f"{code.co_filename}:{code.co_firstlineno}"].add(str(file))


def pytest_sessionfinish():
    """Write what was noted."""
    RAN.write_text(json.dumps({place: sorted(files) for place, files in _ran.items()}), encoding="utf-8")
