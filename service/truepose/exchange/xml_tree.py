"""XML as a tree that knows its lines: elements and attributes, no entities and no other files."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final, NoReturn
from xml.parsers import expat

from truepose.exchange.errors import BadValueError, InputFileError, MissingEntryError, UnreadableFileError

_DEEPEST: Final = 100  # no description of a robot nests deeper than ten


@dataclass(frozen=True, slots=True)
class Element:
    """An element with its place in the file."""

    file: str
    tag: str
    attributes: dict[str, str]
    line: int
    children: list["Element"] = field(default_factory=list)

    def fail(self, sentence: str, kind: type[InputFileError] = BadValueError) -> NoReturn:
        """Raise `kind` at this place."""
        raise kind(sentence, file=self.file, line=self.line)

    def text(self, name: str) -> str:
        """Return an attribute that must be there."""
        if not self.attributes.get(name, "").strip():
            self.fail(f"<{self.tag}> needs the attribute {name}", MissingEntryError)
        return self.attributes[name]

    def all(self, tag: str) -> Iterator["Element"]:
        """Yield the children of a tag."""
        return (child for child in self.children if child.tag == tag)

    def optional(self, tag: str) -> "Element | None":
        """Return the only child of a tag, None where there is none."""
        found = list(self.all(tag))
        if len(found) > 1:
            found[1].fail(f"<{self.tag}> has a second <{tag}>")
        return found[0] if found else None


def parse_xml(file: str, data: bytes) -> Element:
    """Return the root of an XML document.

    Raises
    ------
    UnreadableFileError
        It is no XML, is cut off, nests without end, or declares a document type: entities of one could grow
        without end or name files of the machine.
    """
    tree = _Tree(file)
    try:
        tree.parser.Parse(data, True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise UnreadableFileError(f"this is not XML: {reason}", file=file, line=error.lineno) from error
    return tree.root


class _Tree:
    """What the parser calls while it reads."""

    def __init__(self, file: str) -> None:
        self._file = file
        self._open = [Element(file, "", {}, 1)]
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._refuse_document_type

    @property
    def root(self) -> Element:
        return self._open[0].children[0]

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(self._file, tag, attributes, self.parser.CurrentLineNumber)
        if len(self._open) > _DEEPEST:
            element.fail("elements are nested too deep", UnreadableFileError)
        self._open[-1].children.append(element)
        self._open.append(element)

    def _end(self, _tag: str) -> None:
        self._open.pop()

    def _refuse_document_type(self, *_declared: object) -> None:
        raise UnreadableFileError(
            "the file declares a document type, which no robot needs; remove the line with <!DOCTYPE",
            file=self._file,
            line=self.parser.CurrentLineNumber,
        )
