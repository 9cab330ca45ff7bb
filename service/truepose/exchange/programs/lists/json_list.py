"""Lists of targets as JSON (.json): `{"targets": [{"target": "p1", "x_mm": 1.0, ...}]}`, or only the list."""

import re
from collections.abc import Iterator
from typing import Final

from truepose.exchange.document import Node, json_document
from truepose.exchange.json_text import KeyPath
from truepose.exchange.programs.draft import Draft
from truepose.exchange.programs.lists.target_rows import NAME, NEST, joint_names, required, target_of
from truepose.exchange.programs.source import Source

_TARGETS: Final = "targets"
_TOKEN: Final = re.compile(r'(?P<text>"(?:[^"\\]|\\.)*")|(?P<value>[-+.\w]+)|(?P<sign>[\[\]{},:])')
_ESCAPE: Final = re.compile(r'^"|"$')


def read(draft: Draft) -> None:
    """Read a list of targets; raises InputFileError as any document does, with the key."""
    source = draft.source
    root = json_document(source.name, source.data)
    entries = root.key(_TARGETS) if isinstance(root.value, dict) else root
    places = {path: span for path, span in _values(source) if path[: len(entries.path)] == entries.path}
    for entry in entries.items():
        _read_entry(draft, entry, places)


def _read_entry(draft: Draft, entry: Node, places: dict[KeyPath, tuple[int, int]]) -> None:
    held = {}
    names = entry.entries()
    for name in dict.fromkeys((*required(names), *joint_names(names))):
        node = entry.key(name)
        node.number()
        held[name] = draft.source.number(*places[node.path])
    named, nest = entry.optional(NAME), entry.optional(NEST)
    start = min(number.start for number in held.values())
    line = draft.source.line(start)
    name = named.text() if named else f"line {line}"
    draft.add(target_of(draft.source, name, line, held, nest.whole() if nest else None))


def _values(source: Source) -> Iterator[tuple[KeyPath, tuple[int, int]]]:
    """Yield path and place of every number, true, false and null of a document that is sound."""
    path: list[str | int] = []
    is_key = False
    for token in _TOKEN.finditer(source.text, source.start):
        match token["sign"]:
            case "{" | "[" as opening:
                path.append(0 if opening == "[" else "")
                is_key = opening == "{"
            case "}" | "]":
                path.pop()
            case ",":
                last = path[-1]
                path[-1] = last + 1 if isinstance(last, int) else last
                is_key = isinstance(last, str)
            case None if token["text"] and is_key:
                path[-1] = _ESCAPE.sub("", token["text"])
                is_key = False
            case None if token["value"]:
                yield tuple(path), token.span()
