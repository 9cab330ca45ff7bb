"""A test says what it holds: it asserts something itself, or by a helper whose name says that it does."""

import ast
from pathlib import Path

import pytest

_CHECKOUT = Path(__file__).parents[3]
_FAILING = {"pytest.raises", "pytest.warns", "pytest.fail"}
_SAYING = ("assert_", "require_")  # how the name of a helper begins that fails


def _tests(tree):
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))
    return [function for function in functions if function.name.startswith("test_")]


def _asserts(function):
    return any(_fails(node) for node in ast.walk(function))


def _fails(node):
    if isinstance(node, ast.Call):
        called = ast.unparse(node.func)
        return called in _FAILING or called.split(".")[-1].startswith(_SAYING) or called.startswith("expect(")
    return isinstance(node, ast.Assert) and not isinstance(node.test, ast.Constant)


def test_every_test_asserts_something():
    silent = [
        f"{path.relative_to(_CHECKOUT)}:{function.name}"
        for folder in ("tests", "drivers")
        for path in sorted((_CHECKOUT / folder).rglob("test_*.py"))
        for function in _tests(ast.parse(path.read_text(encoding="utf-8")))
        if not _asserts(function)
    ]

    assert silent == []


@pytest.mark.parametrize(
    ("body", "asserted"),
    [
        ("run()", False),
        ("assert True", False),
        ("assert run()", True),
        ("with pytest.raises(ValueError): run()", True),
        ("helpers.require_whole(run())", True),
        ("expect(page).to_have_title('x')", True),
        ("await assert_refused(run())", True),
    ],
)
def test_a_test_without_an_assertion_is_found(body, asserted):
    (function,) = _tests(ast.parse(f"async def test_it():\n    {body}"))

    assert _asserts(function) is asserted
