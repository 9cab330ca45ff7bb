"""What arrives at the service, when, and what the arm does: seen from outside, beside the page's own word."""

import contextlib
import json
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from truepose.storage.engine.sqlite_connections import LIBRARY

DONE: Final = 200
HALTS: Final = frozenset({"pause", "stop", "abort"})


@dataclass(slots=True)
class Arrival:
    """One request of an act, as the service got it."""

    key: str
    arrived_s: float
    body: bytes = b""
    status: int | None = None
    answered_s: float = 0.0

    @property
    def said(self) -> dict[str, Any]:
        """Return what it asked for; nothing where it did not arrive as a whole."""
        try:
            found: dict[str, Any] = json.loads(self.body)
        except ValueError:
            return {}
        return found


@dataclass(slots=True)
class Onlooker:
    """Passes everything on and remembers the acts."""

    app: ASGIApp
    arrivals: list[Arrival] = field(default_factory=list)
    sent_s: list[float] = field(default_factory=list)  # motions

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        if scope["type"] != "http" or not scope["path"].endswith("/commands"):
            await self.app(scope, receive, send)
            return
        key = dict(scope["headers"]).get(b"idempotency-key", b"").decode()
        arrival = Arrival(key, time.monotonic())
        self.arrivals.append(arrival)

        async def received() -> Message:
            message = await receive()
            arrival.body += message.get("body", b"")
            return message

        async def answered(message: Message) -> None:
            if message["type"] == "http.response.start":
                arrival.status, arrival.answered_s = message["status"], time.monotonic()
            await send(message)

        await self.app(scope, received, answered)

    def watch(self, robot: Any) -> None:
        """Remember when a robot is sent somewhere."""
        move = robot.move_joints

        async def noted(target_rad: Any) -> None:
            self.sent_s.append(time.monotonic())
            await move(target_rad)

        robot.move_joints = noted

    def moved_unasked(self, *, each: bool) -> list[str]:
        """Return the motions that nobody had let begin since the arm was to halt; `each` needs a word."""
        done = [arrival for arrival in self.arrivals if arrival.status == DONE]
        events = [(arrival.arrived_s, "go") for arrival in done if _lets_move(arrival.said, each)]
        events += [(arrival.answered_s, "halt") for arrival in done if arrival.said["command"] in HALTS]
        free, faults = False, []
        for at_s, what in sorted(events + [(sent_s, "motion") for sent_s in self.sent_s]):
            if what == "motion" and not free:
                faults.append(f"a motion at {at_s:.2f} s that nobody had let begin")
            free = what == "go" or (free and what == "motion" and not each)
        return faults


def _lets_move(said: dict[str, Any], each: bool) -> bool:
    if each:
        return said["command"] == "confirm" and (said["step_id"] or "").endswith("/move")
    return said["command"] in {"confirm", "resume"}


def answered_in(database: Path) -> frozenset[str]:
    """Return the keys whose answers are kept."""
    return frozenset(key for (key,) in _read(database, "SELECT key FROM act_answers"))


def entries_of(database: Path, keys: Iterable[str]) -> dict[str, list[int]]:
    """Return the numbers of the ledger's lines for each key."""
    rows = _read(database, "SELECT key, id FROM session_entries WHERE key IS NOT NULL")
    return {key: [id for kept, id in rows if kept == key] for key in keys}


def _read(database: Path, query: str) -> list[tuple[Any, ...]]:
    # By the library of the service, which runs in this process: another one would let go of its locks.
    with contextlib.closing(LIBRARY.connect(f"file:{database}?mode=ro", uri=True)) as connection:
        rows: list[tuple[Any, ...]] = connection.execute(query).fetchall()
    return rows
