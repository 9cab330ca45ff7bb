"""What `import truepose as tp` offers is what it says, is documented, and costs nothing before it is used."""

import ast
import doctest
import inspect
import subprocess
import sys

import pytest

import truepose
from tests.helpers.checkout import CHECKOUT

_NAMES = [name for name in truepose.__all__ if name != "__version__"]
_HEAVY = ("numpy", "scipy", "matplotlib", "pandas", "pydantic", "truepose.notebook", "truepose.reports")


def _loaded_after(code):
    program = f"import sys; {code}; print(*[name for name in {_HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_every_name_is_there():
    assert {name for name in _NAMES if not inspect.isroutine(getattr(truepose, name))} == {
        name for name in _NAMES if inspect.isclass(getattr(truepose, name))
    }
    assert dir(truepose) == sorted(truepose.__all__)


def test_type_checkers_see_the_names_that_a_program_gets():
    tree = ast.parse(inspect.getsource(truepose))
    guarded = next(node for node in tree.body if isinstance(node, ast.If)).body

    told = {alias.name: node.module for node in guarded for alias in node.names}

    assert sorted(told) == sorted(_NAMES)
    assert {name: getattr(truepose, name).__module__ for name in told} == told


def test_a_name_that_there_is_not_is_refused_as_everywhere():
    with pytest.raises(AttributeError, match="module 'truepose' has no attribute 'identfy'"):
        truepose.identfy  # noqa: B018


@pytest.mark.parametrize("code", ["import truepose", "import truepose.cli"])
def test_nothing_heavy_is_loaded_before_it_is_used(code):
    assert _loaded_after(code) == []


def test_a_worker_starts_without_the_notebook():
    loaded = _loaded_after("import truepose.analysis.job_queue.supervisor")

    assert {"matplotlib", "pandas", "truepose.notebook", "truepose.reports"}.isdisjoint(loaded)


def test_a_first_use_loads_what_it_needs():
    assert "numpy" in _loaded_after("import truepose; truepose.read_campaign")


@pytest.mark.parametrize("name", _NAMES)
def test_every_name_has_an_example_that_runs(name, monkeypatch):
    monkeypatch.chdir(CHECKOUT)
    thing = getattr(truepose, name)
    example = doctest.DocTestParser().get_doctest(inspect.getdoc(thing), {}, name, None, 0)

    report = []
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    result = doctest.DocTestRunner(optionflags=flags).run(example, out=report.append)

    assert result.attempted > 0
    assert result.failed == 0, "".join(report)


@pytest.mark.parametrize("name", [name for name in _NAMES if inspect.isfunction(getattr(truepose, name))])
def test_every_function_says_what_it_takes_gives_and_raises(name):
    told = inspect.getdoc(getattr(truepose, name))

    parameters = list(inspect.signature(getattr(truepose, name)).parameters)
    missing = [parameter for parameter in parameters if f"\n{parameter} :" not in told]

    assert "Raises\n------" in told
    assert missing == []


@pytest.mark.parametrize("name", [name for name in _NAMES if name[0].islower()])
def test_help_begins_with_what_somebody_would_type(name):
    signature = str(inspect.signature(getattr(truepose, name)))

    assert "numpy" not in signature
    assert len(signature) < 600
