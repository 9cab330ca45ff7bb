"""Transcripts: what was asked and answered, as text that is the same whenever it is taken down.

Times, secrets and addresses of this run are replaced by their kind. Numbers stay; two transcripts are
the same where their words and whole numbers are, and the others agree to the last digit or a thousandth.
"""

import difflib
import io
import json
import re
import zipfile
from pathlib import Path

from tests.helpers.web.pages import Page

KEPT = Path(__file__).parent / "kept"
_LONGEST_LIST = 4
_OWN_TO_A_RUN = [
    (r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d+)?)?(Z|[+-]\d\d:\d\d| UTC)?", "<time>"),
    (r"\d{4}-\d\d-\d\d", "<day>"),
    (r"\b\d{1,2} (Jan|Feb|Mar|Apr|May|Jun|Jul|Aug|Sep|Oct|Nov|Dec)[a-z]* \d{4}", "<day>"),
    (r"\b\d\d:\d\d(:\d\d)?\b", "<time>"),
    (r"127\.0\.0\.1:\d+", "<address>"),
    (r"\b(?=\d*[a-f])[0-9a-f]{12,}\b", "<digest>"),
    (r"\b\d+(-[A-Z2-7]{4}){4}\b", "<head>"),
    (r"\d+(\.\d+)? (ms|s)\b(?= ago|\.|,)", "<duration>"),
    (r"\b[\d.]+ [GT]B are free", "<space> are free"),
    (r"/tmp/[\w./-]+|/dev/shm/[\w./-]+", "<file>"),
    (r"\b\d+\.\d+\.\d+(\.dev\d+)?(\+\w+)?\b", "<version>"),
]
_KEYS_OF_A_RUN = {
    "fraction", "remaining_s", "elapsed_s", "pace_s_per_reading", "secret", "token", "link", "url", "qr_svg",
}  # fmt: skip
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_FLAT_LIST = re.compile(r"\[[^\[\]{}]{0,200}\]")


class Transcript:
    """Lines of one subject, and the file that keeps them."""

    def __init__(self, name):
        self.name = name
        self._lines = []

    def add(self, *lines):
        """Take lines down."""
        self._lines += lines

    @property
    def text(self):
        """All lines, without what is this run's own."""
        return without_own("\n".join(self._lines)) + "\n"

    @property
    def file(self):
        """Where the text is kept."""
        return KEPT / f"{self.name}.txt"

    def keep(self):
        """Write the text to its file."""
        self.file.parent.mkdir(parents=True, exist_ok=True)
        self.file.write_text(self.text, encoding="utf-8")

    def changes(self):
        """Return the lines of a comparison with what is kept; none where both say the same."""
        kept = self.file.read_text(encoding="utf-8") if self.file.exists() else ""
        return list(changes(kept, self.text, self.name))


def without_own(text):
    """Return a text without what belongs to this run alone."""
    for pattern, kind in _OWN_TO_A_RUN:
        text = re.sub(pattern, kind, text)
    return text


def changes(kept, taken, name):
    """Yield a comparison of two transcripts, in which lines that differ by a last digit are one line."""
    before, after = kept.splitlines(), taken.splitlines()
    words = difflib.SequenceMatcher(
        None, *([_NUMBER.sub("#", line) for line in one] for one in (before, after)), False
    )
    for tag, a, b, c, d in words.get_opcodes():
        if tag == "equal":
            pairs = zip(before[a:b], after[c:d], strict=True)
            differing = [(old, new) for old, new in pairs if not _agree(old, new)]
        else:
            differing = [(old, None) for old in before[a:b]] + [(None, new) for new in after[c:d]]
        for old, new in differing:
            yield from (
                f"{name}: {sign}{line}" for sign, line in (("-", old), ("+", new)) if line is not None
            )


def _agree(old, new):
    return all(map(_alike, _NUMBER.findall(old), _NUMBER.findall(new)))


def _alike(old, new):
    if old == new or not ("." in old + new or "e" in (old + new).lower()):  # a count, a status, a byte
        return old == new
    last_digit = max(_last_digit(old), _last_digit(new))
    return abs(float(old) - float(new)) <= max(1.001 * last_digit, 1e-3 * abs(float(old)), 1e-9)


def _last_digit(number):
    digits, _, power = number.lower().partition("e")
    decimals = len(digits.partition(".")[2])
    return 10.0 ** (int(power or 0) - decimals) if "." in digits else 0.0


def printed(document):
    """Return JSON as indented text; of a long list its first entries and their number."""
    text = json.dumps(_shortened(document), indent=1, ensure_ascii=False, sort_keys=True)
    return _FLAT_LIST.sub(lambda found: " ".join(found[0].split()), text)


def _shortened(node):
    match node:
        case dict():
            return {
                key: "<run>" if key in _KEYS_OF_A_RUN else _shortened(value) for key, value in node.items()
            }
        case list() if len(node) > _LONGEST_LIST:
            return [*map(_shortened, node[:_LONGEST_LIST]), f"... {len(node)} in all"]
        case list():
            return [_shortened(value) for value in node]
        case float():
            return float(f"{node:.6g}")
        case str() if len(node) > 20_000:
            return f"<{len(node) // 1000} thousand characters>"
        case _:
            return node


def told(body, media_type):
    """Return what the body of an answer says to who reads it."""
    if media_type.endswith(("ndjson", "jsonl", "json-lines")):
        return "\n".join(printed(json.loads(line)) for line in body.splitlines()[:_LONGEST_LIST])
    if media_type.endswith("json"):
        return printed(json.loads(body)) if body else ""
    if media_type == "text/html":
        return visible(body.decode())
    if media_type == "application/zip":
        with zipfile.ZipFile(io.BytesIO(body)) as archive:
            return "\n".join(
                f"{name}:\n{_first_lines(archive.read(name))}" for name in sorted(archive.namelist())
            )
    if media_type.startswith("text/"):
        return _first_lines(body)
    return f"<{media_type}>"


def _first_lines(body):
    lines = body.decode("utf-8", "replace").splitlines()
    return "\n".join([*lines[:40], *([f"... {len(lines)} lines in all"] if len(lines) > 40 else [])])


def visible(html):
    """Return the text of a page, a line for each piece of it."""
    return "\n".join(Page(html).pieces)
