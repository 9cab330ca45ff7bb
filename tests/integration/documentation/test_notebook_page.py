"""The page for notebooks: its code runs as it stands there, and prints what it says."""

import contextlib
import io
import re
import shutil

import pytest

from tests.helpers.checkout import CHECKOUT

PAGE = CHECKOUT / "docs" / "notebook.md"
_BLOCKS = re.findall(r"```(python|text)\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
CODE = [text for kind, text in _BLOCKS if kind == "python"]
_MOST_LINES = 10  # from own data to a named cause


def promised():
    """Every block of code with what the page says that it prints."""
    following = [*_BLOCKS[1:], ("", "")]
    return [
        (code, said if kind_of_next == "text" else "")
        for (kind, code), (kind_of_next, said) in zip(_BLOCKS, following, strict=True)
        if kind == "python"
    ]


@pytest.fixture
def beside_the_examples(tmp_path, monkeypatch):
    pytest.importorskip("pandas")
    shutil.copytree(CHECKOUT / "docs" / "examples", tmp_path / "docs" / "examples")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_code_prints_what_the_page_says(beside_the_examples):
    names = {}

    for code, said in promised():
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, str(PAGE), "exec"), names)
        assert printed.getvalue() == said

    kept = {path.name for path in beside_the_examples.iterdir()}
    assert {"wave.png", "errors.png", "robot.json"} <= kept


def test_ten_lines_lead_from_own_data_to_a_named_cause():
    lines = [line for line in CODE[0].splitlines() if line.strip()]

    assert len(lines) <= _MOST_LINES
    assert "joint harmonics (joint 4)" in promised()[0][1]
