"""The ledger as the runner has it: every line reaches the disk before anything follows from it."""

import asyncio
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from truepose.domain.artefacts import BallbarKit
from truepose.domain.ballbar import BallbarPlan, BallbarStep, EntryKind, LedgerEntry, LengthTaken
from truepose.domain.errors import RecordRefusedError
from truepose.domain.people import tidy_name
from truepose.domain.session import SessionState
from truepose.sequencing.ballbar import control
from truepose.sequencing.ballbar.acts import Act, ActOutcome
from truepose.sequencing.ballbar.plan.agenda import steps
from truepose.sequencing.ballbar.record import Record
from truepose.sequencing.ballbar.situation import Situation, situation_of
from truepose.sequencing.engine.ledger import Ledger
from truepose.sequencing.engine.states import after_restart, require_transition
from truepose.sequencing.tracker.patience import trouble_with
from truepose_drivers.api import Clock

_KEPT_BEFORE = "That was done before; nothing was done again."


class Book:
    """Appends lines and knows the situation that follows; its caller lets one append at a time."""

    def __init__(
        self,
        plan: BallbarPlan,
        kit: BallbarKit,
        ledger: Ledger,
        clock: Clock,
        entries: tuple[LedgerEntry, ...],
    ) -> None:
        self._plan = plan
        self._kit = kit
        self._ledger = ledger
        self._clock = clock
        self._entries = list(entries)
        self._record = Record()
        for entry in entries:
            self._record.apply(entry)
        state = self._record.state
        self._restarted_as = after_restart(state) if after_restart(state) is not state else None
        if state is SessionState.AWAITING_CONFIRMATION:
            self._restarted_as = state  # the question is put again
        if self._restarted_as is not None:
            self._record.enter(self._restarted_as, control.RESTARTED)
        self._outcomes: dict[str, ActOutcome] = {}  # by key, of this run
        self._changed = asyncio.Event()
        self.trouble: str | None = None  # what is said while lines are refused; nothing moves meanwhile
        self.refused = asyncio.Event()  # set as long as that lasts
        self.version = 0
        self.situation = self._now()

    @property
    def entries(self) -> tuple[LedgerEntry, ...]:
        """Every line so far."""
        return tuple(self._entries)

    @property
    def planned(self) -> Iterator[BallbarStep]:
        """All steps as they were planned, before anything was skipped or aimed anew."""
        return steps(self._plan, self._kit)

    @property
    def last_length(self) -> tuple[LengthTaken, str] | None:
        """The length that was read last, and the step it was stored for ("": it was not); None: none was."""
        entry = next((entry for entry in reversed(self._entries) if entry.length is not None), None)
        if entry is None or entry.length is None:
            return None
        return entry.length, entry.step_id if entry.kind is EntryKind.MEASURED else ""

    async def open(self) -> None:
        """Record, once, that the service was started anew where an earlier run had begun the session."""
        if self._restarted_as is not None:
            text = control.state_text(self._restarted_as, control.RESTARTED)
            await self.append(EntryKind.CONTROL, text=text)
            self._restarted_as = None

    async def append(self, kind: EntryKind, step_id: str = "", act: Act | None = None, **fields: Any) -> int:
        """Keep a line; returns its number. What follows from it is seen once it is on disk.

        Raises RecordRefusedError where it cannot be kept now; then it was not, and nothing follows.
        """
        acting = self.situation.acting
        time_s = await self._clock.now_s()
        entry = LedgerEntry(step_id, kind, time_s, **fields)
        if act is not None:
            entry = replace(entry, person=tidy_name(act.person) or None, tablet=act.tablet, key=act.key)
        elif acting is not None:
            entry = replace(entry, person=acting.person, tablet=acting.tablet)
        number = await self._keep(entry)
        self._entries.append(entry)
        self._record.apply(entry)
        self.situation = self._now()
        self.tell()
        return number

    async def accepted(self) -> None:
        """Return once lines are taken again; at once where none was refused."""
        if self.refused.is_set():
            await self._ledger.writable()
            self._take_note(None)

    async def _keep(self, entry: LedgerEntry) -> int:
        try:
            number = await self._ledger.append(entry)
        except RecordRefusedError as error:
            self._take_note(trouble_with(error))
            raise
        self._take_note(None)
        return number

    def _take_note(self, trouble: str | None) -> None:
        if trouble == self.trouble:
            return
        self.trouble = trouble
        if trouble is None:
            self.refused.clear()
        else:
            self.refused.set()
        self.tell()

    async def enter(self, state: SessionState, reason: str, act: Act | None = None) -> int:
        """Record a change of state; raises NotNowError where no such change is possible."""
        require_transition(self.situation.state, state)
        return await self.append(EntryKind.CONTROL, act=act, text=control.state_text(state, reason))

    def keep_outcome(self, key: str, outcome: ActOutcome) -> ActOutcome:
        """Remember what came of a request."""
        self._outcomes[key] = outcome
        return outcome

    async def earlier_outcome(self, key: str) -> ActOutcome | None:
        """Return what came of a request with this key before; None where it is new."""
        if key in self._outcomes:
            return self._outcomes[key]
        place = self._record.keys.get(key)
        if place is None:
            return None
        return ActOutcome(_KEPT_BEFORE, await self._ledger.append(self._entries[place]))

    def knows(self, key: str) -> bool:
        """Whether a request with this key was answered, in this run or in an earlier one."""
        return key in self._outcomes or key in self._record.keys

    def tell(self) -> None:
        """Wake everybody who waits for a change."""
        self.version += 1
        self._changed.set()
        self._changed = asyncio.Event()

    async def changed(self, after: int) -> int:
        """Return the version once it is above `after`."""
        while self.version <= after:
            await self._changed.wait()
        return self.version

    def _now(self) -> Situation:
        return situation_of(self._plan, self._kit, self._record)
