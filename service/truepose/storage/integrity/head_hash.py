"""The head of the chain: one short code that stands for every record kept so far.

Each session has a stream of its own; the head is taken over the newest hash of every stream, so that it tells
of a record of any of them that was changed, taken out or exchanged afterwards, also where the chain was
computed anew. It is short enough to be printed on a report and typed off it: RFC 4648 base 32 knows neither 0
nor 1, and 80 bits leave nobody a second database with the same one.
"""

import base64
import hashlib
import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from truepose.storage.errors import ChainHeadError

# Begins the digest, so that it can be no hash of anything else that this program makes, and may change with
# the next form of a head.
_DOMAIN: Final = b"truepose chain head 1"
_ENTRY: Final = struct.Struct(">q32s")
_BYTES: Final = 10  # of the digest that are printed
_PRINTED: Final = re.compile(r"[0-9]+ [A-Z2-7]{16}")
# From stream to stream by the index: a million links are not looked through for some hundred sessions.
_STREAMS: Final = """
    WITH RECURSIVE streams(stream) AS (
        SELECT min(stream) FROM links
        UNION ALL
        SELECT (SELECT min(stream) FROM links WHERE stream > streams.stream) FROM streams
        WHERE streams.stream IS NOT NULL
    )
    SELECT stream, (
        SELECT hash FROM links WHERE stream = streams.stream AND id <= ? ORDER BY id DESC LIMIT 1
    ) FROM streams WHERE stream IS NOT NULL ORDER BY stream
"""


@dataclass(frozen=True, slots=True)
class Head:
    """The chain as far as it went when a report was made."""

    links: int  # how many records it stands for
    code: str  # four groups of four letters and digits

    @property
    def text(self) -> str:
        """Return what is printed: "4711-K3QF-7ZWD-M2PA-XY5R"."""
        return f"{self.links}-{self.code}"


def read_head(printed: str) -> Head:
    """Return the head that somebody typed off a report; raises ChainHeadError."""
    # Typed off paper: blanks for hyphens, small letters, and any grouping are taken.
    links, *groups = re.split(r"[\s-]+", printed.strip().upper())
    code = "".join(groups)
    if not _PRINTED.fullmatch(f"{links} {code}"):
        raise ChainHeadError(
            f"'{printed}' is not a chain head; a chain head looks like 4711-K3QF-7ZWD-M2PA-XY5R, as printed"
            " in reports."
        )
    return Head(int(links), _grouped(code))


def newest_head(connection: Any) -> Head:
    """Return the head of a database as it is."""
    return head_after(connection, int(connection.execute("SELECT max(id) FROM links").fetchone()[0] or 0))


# Links only ever come behind others, so the head of an earlier moment can be found at any time; a report of
# last year is held against the database of today.
def head_after(connection: Any, links: int) -> Head:
    """Return the head as it was when the chain had that many links."""
    streams = connection.execute(_STREAMS, (links,))  # of a session that began later there is none
    return head_of(links, {stream: bytes(newest) for stream, newest in streams if newest is not None})


def head_of(links: int, newest: Mapping[int, bytes]) -> Head:
    """Return the head of a chain with so many links, by the newest hash of each stream."""
    digest = hashlib.sha256(_DOMAIN + links.to_bytes(8))
    # In one order, whatever the engine returns.
    for stream in sorted(newest):
        digest.update(_ENTRY.pack(stream, newest[stream]))
    return Head(links, _grouped(base64.b32encode(digest.digest()[:_BYTES]).decode()))


def contradiction(connection: Any, printed: Head) -> str | None:
    """Return what is said where a database does not hold what a printed head stands for; None: it does."""
    newest = newest_head(connection)
    if newest.links < printed.links:
        gone = printed.links - newest.links
        return (
            f"The newest {gone} records are missing: the head {printed.text} was printed for "
            f"{printed.links}, the database has {newest.links}."
        )
    if head_after(connection, printed.links) != printed:
        return f"The first {printed.links} records do not match the printed head {printed.text}."
    return None


def _grouped(code: str) -> str:
    return "-".join(code[at : at + 4] for at in range(0, len(code), 4))
