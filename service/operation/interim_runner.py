# ruff: noqa
"""Interim: stands in for the runner of ballbar sessions until that is there; nothing moves, nothing is measured."""

import asyncio
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Any

from service.domain.ballbar import ArrivalTaken, EntryKind, LedgerEntry, LengthTaken, StepKind
from service.domain.session import SessionState
from service.sequencing.ballbar import control
from service.sequencing.ballbar.acts import Act, ActName, ActOutcome
from service.sequencing.ballbar.record import READINGS
from service.sequencing.ballbar.situation import situation
from service.sequencing.errors import NotNowError

_STATES = {
    ActName.START: SessionState.RUNNING,
    ActName.PAUSE: SessionState.PAUSED,
    ActName.RESUME: SessionState.RUNNING,
    ActName.STOP: SessionState.AWAITING_CONFIRMATION,
    ActName.ABORT: SessionState.ABORTED,
}


@dataclass(frozen=True)
class BallbarCell:
    ballbar: Any
    robot_controller: Any
    clock: Any
    robot: Any
    joint_limits: Any = None


@dataclass(frozen=True)
class LiveSample:
    time_s: float
    length_mm: float | None
    deviation_mm: float | None
    state: str
    stable_share: float
    spread_mm: float
    robot_still: bool
    sampled_at_ms: float


Foresight = Any


class BallbarRunner:
    robot_moving = False

    def __init__(self, plan, kit, cell, ledger, foresight, entries=()):  # type: ignore[no-untyped-def]
        self._plan, self._kit, self._ledger, self._entries = plan, kit, ledger, list(entries)
        self.version, self._event, self._done = 0, asyncio.Event(), asyncio.Event()
        self._situation = situation(plan, kit, self._entries)

    @property
    def situation(self):  # type: ignore[no-untyped-def]
        return self._situation

    @property
    def question(self) -> str | None:
        return None

    async def run(self) -> SessionState:
        if self._situation.state not in {SessionState.PLANNED, SessionState.AWAITING_CONFIRMATION}:
            text = control.state_text(SessionState.AWAITING_CONFIRMATION, "The service was restarted.")
            await self._append(LedgerEntry(self._id(), EntryKind.CONTROL, time.monotonic(), text=text))
        await self._done.wait()
        return self._situation.state

    async def changed(self, after: int) -> int:
        while self.version <= after:
            await self._event.wait()
        return self.version

    def _id(self) -> str:
        return self._situation.step.id if self._situation.step else ""

    async def _append(self, entry: LedgerEntry) -> int:
        number = await self._ledger.append(entry)
        self._entries.append(entry)
        self._situation = situation(self._plan, self._kit, self._entries)
        self.version += 1
        self._event.set()
        self._event = asyncio.Event()
        if self._situation.state in {SessionState.ABORTED, SessionState.FINISHED}:
            self._done.set()
        return int(number)

    async def act(self, act: Act) -> ActOutcome:
        step = self._situation.step
        if act.step_id not in {None, self._id()}:
            raise NotNowError("The session is at another step now; look again.")
        now, who = time.monotonic(), (act.person, act.tablet, act.key)
        acting = self._situation.acting
        if act.name in _STATES or (
            act.name is ActName.CONFIRM and self._situation.state is not SessionState.RUNNING
        ):
            state = _STATES.get(act.name, SessionState.RUNNING)
            entry = LedgerEntry(
                self._id(), EntryKind.CONTROL, now, *who, control.state_text(state, "asked for")
            )
        elif act.name is ActName.HAND_OVER:
            entry = LedgerEntry(self._id(), EntryKind.CONTROL, now, *who, control.HAND_OVER)
        elif acting is not None and acting.tablet != act.tablet:
            raise NotNowError("Another tablet acts; take over first.")
        elif step is None:
            raise NotNowError("Nothing is left to do.")
        elif act.name is ActName.SKIP:
            entry = LedgerEntry(step.id, EntryKind.SKIPPED, now, *who, act.reason)
        elif act.name is ActName.STORE and step.kind in READINGS:
            mm = step.expected_mm or 0.0
            taken = LengthTaken(
                mm, 0.0, 0.0, 0.0016, 0.001, 20, self._situation.initialisations + (step.kind is StepKind.INITIALISE),
                True, 23.0, "interim", "", "", now,
            )  # fmt: skip
            entry = LedgerEntry(step.id, EntryKind.MEASURED, now, *who, length=taken)
        elif act.name is ActName.CONFIRM and step.kind is StepKind.MOVE:
            await self._append(LedgerEntry(step.id, EntryKind.CONFIRMED, now, *who))
            target = step.target_rad or ()
            arrival = ArrivalTaken(target, target, (1,) * len(target), now)
            entry = LedgerEntry(step.id, EntryKind.MOVED, now, arrival=arrival)
        elif act.name is ActName.CONFIRM:
            entry = LedgerEntry(step.id, EntryKind.CONFIRMED, now, *who)
        else:
            raise NotNowError(f"{act.name} does nothing yet.")
        return ActOutcome("Done.", await self._append(entry))

    async def live(self) -> AsyncIterator[LiveSample]:
        while not self._done.is_set():
            yield LiveSample(time.monotonic(), 300.0, 0.0, "in_range", 0.5, 0.001, True, time.time() * 1000)
            await asyncio.sleep(0.05)
