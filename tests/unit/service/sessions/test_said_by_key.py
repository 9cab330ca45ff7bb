"""Whatever a session says to people is a message of the catalogues; no sentence stands in its code."""

import ast
import re
from pathlib import Path

import pytest

import truepose

SERVICE = Path(truepose.__file__).parent
ROOMS = [path for room in ("sessions", "people") for path in sorted((SERVICE / room).rglob("*.py"))]
ELSEWHERE = "operation/lookout"  # how the computer is: said to whoever asks
LEFT = {  # a driver's error, in a driver's words; notes to the log's traceback; a mistake of the program
    "sessions/engine/robot.py",
    "sessions/engine/unattended.py",
    "sessions/ballbar/transitions.py",
    "sessions/guide/guide.py",
}
WORDS = 5  # fewer are a name, or a part of what is logged


def sentences(tree):
    """Yield each text of a module that reads like a sentence, but those of docstrings and of logs."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        if isinstance(node, ast.Call) and ast.unparse(node.func).startswith("_LOG."):
            continue
        if isinstance(node, ast.JoinedStr) or (
            isinstance(node, ast.Constant) and isinstance(node.value, str)
        ):
            parts = getattr(node, "values", [node])
            said = "".join(str(part.value) for part in parts if isinstance(part, ast.Constant))
            if len(re.findall(r"\b[a-z]+\b", said)) >= WORDS and " " in said.strip():
                yield node.lineno, said
        else:
            yield from sentences(node)


@pytest.mark.parametrize(
    "path",
    [path for path in ROOMS if not path.relative_to(SERVICE).as_posix().startswith(ELSEWHERE)],
    ids=lambda path: path.relative_to(SERVICE).as_posix(),
)
def test_a_session_says_messages(path):
    found = list(sentences(ast.parse(path.read_text(encoding="utf-8"))))

    assert found == [] or path.relative_to(SERVICE).as_posix() in LEFT


def test_a_sentence_in_the_code_is_found():
    code = """
def say(name):
    'Say what is to be said of the arm, and no more.'
    raise Refused(f"The arm of {name} is painted green.")
"""

    assert [line for line, _ in sentences(ast.parse(code))] == [4]
