"""Whether a page of a cell's chain is what the cell wrote: each record against its link and the link before.

A record that stays in the cell is represented by the hash of its link. What rests on it is verified all the
same; only tables that never leave may be missing, so that nothing can be kept back unseen.
"""

import json
from collections.abc import Iterable, Mapping
from typing import Any, Final

from truepose.storage.errors import TamperedRecordError, UnreadableRowError
from truepose.storage.integrity.hash_chain import GENESIS, linked_hash, stream_of
from truepose.storage.plant.outbox import LEAVING, WHOLE_NUMBERS, from_typed_json
from truepose.storage.plant.records import CollectedLink

_HASH_BYTES: Final = 32
_TOLD: Final = frozenset({"sessions"})  # tables of which a record may come with a secret taken out of it


def verify_page(
    lines: Iterable[Mapping[str, Any]], position: int, heads: Mapping[int, bytes]
) -> tuple[list[CollectedLink], dict[int, bytes]]:
    """Return the links of a page, and the newest hash of each stream after it.

    Parameters
    ----------
    lines : iterable of mapping
        As the cell sent them.
    position : int
        Link that the page follows.
    heads : mapping
        Newest hash of each stream before the page.

    Raises
    ------
    UnreadableRowError
        A line is no link, or not the one that comes next.
    TamperedRecordError
        A record is not that of its link, or is kept back.
    """
    after = dict(heads)
    links: list[CollectedLink] = []
    for line in lines:
        link = _link(line)
        if link.link != position + len(links) + 1:
            raise UnreadableRowError(
                f"Link {position + len(links) + 1} of the chain is expected; the cell sent link {link.link}."
            )
        links.append(link)
        _require_own(link, after.get(link.stream, GENESIS))
        after[link.stream] = link.hash
    return links, after


def _link(line: Any) -> CollectedLink:
    if not isinstance(line, dict):
        raise UnreadableRowError(f"The cell sent {line!r:.60}, which is not a link of the chain.")
    content = line.get("row", line.get("told"))
    try:
        return CollectedLink(
            link=_whole(line, "link"),
            stream=_whole(line, "stream"),
            record=_table(line),
            record_id=_whole(line, "record_id"),
            hash=_hash(line),
            content=None if content is None else _text(content),
            row=None if content is None else from_typed_json(content),
            verified=line.get("row") is not None,
        )
    except (KeyError, TypeError, ValueError) as error:
        raise UnreadableRowError(
            f"The cell sent {line!r:.120}, which is not a link of the chain ({error})."
        ) from error


def _whole(line: Mapping[str, Any], name: str) -> int:
    found = line[name]
    if type(found) is not int or found not in WHOLE_NUMBERS:
        raise TypeError(f"{name} is not a 64-bit integer")
    return found


def _text(content: Any) -> str:
    text = json.dumps(content, ensure_ascii=False)
    text.encode()  # half a character (as \\ud800) no database keeps
    return text


def _table(line: Mapping[str, Any]) -> str:
    found = line["record"]
    if not isinstance(found, str) or not found.isidentifier():
        raise TypeError("record is not a table name")
    return found


def _hash(line: Mapping[str, Any]) -> bytes:
    found = bytes.fromhex(line["hash"])
    if len(found) != _HASH_BYTES:
        raise ValueError("the hash is not 32 bytes long")
    return found


def _require_own(link: CollectedLink, before: bytes) -> None:
    if link.row is None:
        if link.record in LEAVING:
            raise TamperedRecordError(
                f"The cell withholds {_named(link)}, which every cell must send. Check the cell's database "
                "with 'truepose verify'."
            )
        return
    if not link.verified and link.record not in _TOLD:
        raise TamperedRecordError(f"The cell sent {_named(link)} in altered form.")
    names, values = tuple(link.row), tuple(link.row.values())
    # A record that is told without its secret has another hash; its number and stream are the link's all the
    # same (commit 34577c71).
    is_of_link = stream_of(link.record, names, values) == link.stream and link.row.get("id") == link.record_id
    is_as_written = not link.verified or linked_hash(before, link.record, names, values) == link.hash
    if not (is_of_link and is_as_written):
        raise TamperedRecordError(
            f"{_named(link).capitalize()} is not as it was written; nothing from this page was stored. "
            "Check the cell's database with 'truepose verify'."
        )


def _named(link: CollectedLink) -> str:
    return f"record {link.record_id} of the {link.record.replace('_', ' ')} (link {link.link})"
