"""Result files of the Renishaw QC20-W (`.b5r`): what the maker's software wrote of a circular test.

They are XML; no specification is public. Known, from a public program that reads them, are the head of a
result and its features (deviations that the maker's software computed). The element with the raw readings is
not known, so no length of a ballbar can be taken from such a file; what was passed over is named.
"""

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from xml.parsers import expat

from truepose.exchange.document import read_bytes
from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.tables.table_reader import is_number
from truepose.exchange.xml_text import read_xml

_LARGEST_BYTES: Final = 64 << 20  # a test of 1000 readings a second for ten minutes is 20 MB of text
_TEXTS: Final[Mapping[str, str]] = {
    "OPERATOR": "operator",
    "DATE_STARTED": "started",
    "SERIAL_NUMBER": "ballbar_serial",
    "LAST_CALIBRATED": "last_calibrated",
    "PART_NUMBER": "part_number",
}
_ATTRIBUTES: Final[Mapping[str, tuple[str, str]]] = {
    "TEST_SPEC": ("NAME", "test"),
    "MACHINE_TESTED": ("NAME", "machine"),
    "PLANE": ("TEST_PLANE", "plane"),
}
_FEATURE: Final = "FEATURE"
_PART_IN_NAME: Final = re.compile(r"_(\d+)\.b5r$", re.IGNORECASE)
_NOT_XML: Final = "is not a ballbar test result; a .b5r file from the ballbar software is required"


@dataclass(frozen=True, slots=True)
class Feature:
    """A deviation that the maker's software computed; its unit is not in the file."""

    name: str
    kind: str  # as the file says it (DT)
    text: str

    @property
    def value(self) -> float | None:
        """The number, where it is one."""
        value = float(self.text) if is_number(self.text) else math.nan
        return value if math.isfinite(value) else None


@dataclass(frozen=True, slots=True)
class BallbarResult:
    """A ballbar test as its result file tells it; empty where it does not."""

    test: str = ""
    operator: str = ""
    started: str = ""
    machine: str = ""
    plane: str = ""
    ballbar_serial: str = ""
    last_calibrated: str = ""
    part_number: str = ""
    features: tuple[Feature, ...] = ()
    not_understood: Mapping[str, int] = field(default_factory=dict)  # elements passed over, how often each


def read_ballbar_result(path: Path) -> BallbarResult:
    """Read a result file; raises MissingFileError or UnreadableFileError."""
    return ballbar_result_from_bytes(read_bytes(path, most=_LARGEST_BYTES), path.name)


def ballbar_result_from_bytes(data: bytes, name: str) -> BallbarResult:
    """Read the content of a result file called `name`; raises UnreadableFileError."""
    reader = _Reader(name)
    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = reader.begin
    parser.EndElementHandler = reader.end
    parser.CharacterDataHandler = reader.text
    read_xml(parser, name, data, _NOT_XML)
    return reader.result()


class _Reader:
    """Collects what is known from a stream of elements; of what comes twice the first counts."""

    def __init__(self, file: str) -> None:
        self._file = file
        self._found: dict[str, str] = {}
        self._features: list[Feature] = []
        self._passed_over: Counter[str] = Counter()
        self._open: list[tuple[str, Mapping[str, str], list[str]]] = []

    def begin(self, name: str, attributes: Mapping[str, str]) -> None:
        """See an element begin."""
        self._open.append((name, attributes, []))
        if name in _ATTRIBUTES:
            attribute, key = _ATTRIBUTES[name]
            self._keep(key, attributes.get(attribute, ""))
        elif name not in _TEXTS and name != _FEATURE:
            self._passed_over[name] += 1

    def text(self, data: str) -> None:
        """See text in the innermost element."""
        self._open[-1][2].append(data)

    def end(self, _: str) -> None:
        """See the innermost element end."""
        name, attributes, pieces = self._open.pop()
        text = "".join(pieces).strip()
        if name in _TEXTS:
            self._keep(_TEXTS[name], text)
        elif name == _FEATURE:
            self._features.append(Feature(attributes.get("NAME", ""), attributes.get("DT", ""), text))

    def result(self) -> BallbarResult:
        """Return what was found; raises UnreadableFileError for an XML file of something else."""
        if not self._found and not self._features:
            raise UnreadableFileError(_NOT_XML, file=self._file)
        if match := _PART_IN_NAME.search(self._file):
            self._keep("part_number", match[1])  # the maker's software puts it there where it has one
        return BallbarResult(
            **self._found,
            features=tuple(self._features),
            not_understood=dict(sorted(self._passed_over.items())),
        )

    def _keep(self, key: str, value: str) -> None:
        if value.strip():
            self._found.setdefault(key, value.strip())
