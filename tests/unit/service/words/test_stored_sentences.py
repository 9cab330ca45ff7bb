"""Every sentence in the code that a session may keep is known, and so said in the reader's language."""

import ast
import json
import re
from pathlib import Path

import pytest

import truepose
from tests.helpers.kept_sentences import CLEAR
from truepose.words.catalogue import ENGLISH, STORED, catalogue, texts_file

SERVICE = Path(truepose.__file__).parent
KEEPERS = (
    *sorted((SERVICE / "sequencing").rglob("*.py")),
    *(SERVICE / "operation" / name for name in ("present_cell.py", "served_kind.py", "sessions.py")),
    SERVICE / "operation" / "ballbar" / "sessions.py",
)
PLANS = {"dry_run.py", "plan_numbers.py"}  # what they say is answered to who plans; no session comes of it
# What refuses a request, or answers it, goes to whoever asked and into no record.
ANSWERS = {
    "ActOutcome",
    "DeviceInUseError",
    "NotNowError",
    "PersonMissingError",
    "PersonUnknownError",
    "PersonUnreadableError",
    "ReasonMissingError",
    "WatchingTabletError",
}
ENGLISH_TEXTS = json.loads(texts_file(ENGLISH, STORED).read_text(encoding="utf-8")).values()
BLANKS = ("x-7", "X-7.", CLEAR)
WORDS = 3  # fewer are no sentence


def sentences(tree):
    """Yield the line of each text that reads like a sentence, and its parts: texts, and None for a blank."""
    for node in _kept(tree):
        parts = [_part(value) for value in getattr(node, "values", [node])]
        said = "".join(part or "" for part in parts).strip()
        if len(re.findall(r"[A-Za-z]+", said)) >= WORDS and said[-1] in ".?!":
            yield node.lineno, parts


def _kept(node):
    """Yield the texts below a node, but those of docstrings, of logs and of answers."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
            continue
        if isinstance(child, ast.Call) and _is_told_elsewhere(child.func):
            continue
        if isinstance(child, ast.JoinedStr) or _is_text(child):
            yield child
        else:
            yield from _kept(child)


def _is_told_elsewhere(function):
    named = ast.unparse(function)
    return named in ANSWERS or named.startswith("_LOG.")


def _is_text(node):
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _part(node):
    return node.value if _is_text(node) else None


def is_known(parts):
    """Whether a text is said in another language, whatever its blanks hold."""
    filled = ["".join(blank if part is None else part for part in parts).strip() for blank in BLANKS]
    if any({language for _, language in catalogue("de").heard(text)} == {"de"} for text in filled):
        return True
    pattern = re.compile("".join(".+?" if part is None else re.escape(part) for part in parts).strip())
    return any(pattern.fullmatch(text) for text in ENGLISH_TEXTS)


@pytest.mark.parametrize(
    "path",
    [path for path in KEEPERS if path.name not in PLANS],
    ids=lambda path: path.relative_to(SERVICE).as_posix(),
)
def test_every_sentence_that_a_session_may_keep_is_known_in_other_languages(path):
    found = sentences(ast.parse(path.read_text(encoding="utf-8")))

    unknown = [
        f"{line}: {'{}'.join(part or '' for part in parts)}" for line, parts in found if not is_known(parts)
    ]

    assert unknown == []


def test_a_sentence_that_nobody_has_translated_is_found():
    code = '''
def say(name):
    """This is no sentence that anybody keeps."""
    _LOG.warning("This one goes to the log.")
    raise MotionForbiddenError(f"The arm of {name} is painted green.")
'''

    ((line, parts),) = sentences(ast.parse(code))

    assert (line, parts) == (5, ["The arm of ", None, " is painted green."])
    assert not is_known(parts)
    assert is_known(["Configuration ", None, " is left out."])
