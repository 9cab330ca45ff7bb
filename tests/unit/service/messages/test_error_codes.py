"""Codes of errors: everything that can reach a person has one, and every one is used and explained."""

import importlib
import re
from pathlib import Path

import pytest

import truepose
import truepose_drivers
from tests.helpers.words.translations import texts
from truepose.analysis.job_queue.supervisor import TaskRefusedError
from truepose.domain.errors import TrueposeError
from truepose.messages.catalogue import LANGUAGES
from truepose.messages.error_codes import _CODES, CODES, code_of
from truepose_drivers.errors import DriverError, LinkError

SAYS = ("happened", "data", "do")
OF_ERRORS = re.compile(r"^ *class \w+\([^)]*Error\b", re.MULTILINE)


@pytest.fixture(scope="module")
def kinds():
    """Every class of error of the service and the drivers: a linter holds that each is named so."""
    for package in (truepose, truepose_drivers):
        folder = Path(package.__file__).parent
        for path in folder.rglob("*.py"):
            if OF_ERRORS.search(path.read_text("utf-8")):
                parts = path.relative_to(folder.parent).with_suffix("").parts
                importlib.import_module(".".join(parts).removesuffix(".__init__"))
    return sorted({TrueposeError, DriverError, *below(TrueposeError), *below(DriverError)}, key=str)


def below(kind):
    for one in kind.__subclasses__():
        if one.__module__.partition(".")[0] in {"truepose", "truepose_drivers"}:
            yield one
            yield from below(one)


def name_of(kind):
    driver = kind.__module__.startswith("truepose_drivers")
    return f"driver {kind.__name__}" if driver else kind.__name__


def test_every_error_that_is_raised_has_a_code(kinds):
    raised = [kind for kind in kinds if not (kind.__doc__ or "").startswith("Base of every ")]
    without = [kind for kind in raised if code_of(kind.__new__(kind)) == "TP-9001"]

    assert without == []


def test_every_code_is_that_of_an_error_or_of_an_answer(kinds):
    errors = {name_of(kind) for kind in kinds}
    answers = set(re.findall(r'"(\w+)"', "".join(_sources())))

    assert {name for name in _CODES if name not in errors | answers} == set()


def _sources():
    for name in ("web.problems", "web.middleware.security", "web.api.health"):
        module = importlib.import_module(f"truepose.{name}")
        with open(module.__file__, encoding="utf-8") as source:
            yield source.read()


def test_no_code_is_given_twice():
    assert len(set(CODES)) == len(CODES)


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_code_is_explained_and_nothing_else_is(language):
    said = {key for key in texts(language) if key.startswith("error.TP-")}

    assert said == {f"error.{code}.{part}" for code in CODES for part in SAYS}


def test_an_error_without_a_code_of_its_own_has_that_of_its_base():
    class OddLineError(DriverError):
        pass

    assert code_of(OddLineError()) == code_of(ValueError()) == "TP-9001"
    frame = type("OddFrameError", (LinkError,), {})
    assert code_of(frame()) == "TP-3004"


def test_what_a_worker_raised_keeps_its_code():
    assert code_of(TaskRefusedError("There are no readings.", "TP-4002")) == "TP-4002"
    assert code_of(TaskRefusedError("Not understood.")) == "TP-5007"
