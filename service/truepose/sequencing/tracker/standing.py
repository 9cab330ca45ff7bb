"""Where a session stands: its state, what was asked for meanwhile, and the question that is open.

A change of state is visible once it is on disk; what must act at once is the wish. What a person asks for is
answered with the refusal where the disk refuses; the run waits for the disk, without the lock, so that a
person is heard meanwhile.
"""

import asyncio
from collections.abc import Callable
from typing import Final

from truepose.domain.errors import RecordRefusedError
from truepose.domain.session import Progress, SessionState
from truepose.sequencing.engine.arm import Permission
from truepose.sequencing.engine.prompts import Desk, require_person
from truepose.sequencing.engine.states import TRANSITIONS, has_ended, require_transition, words
from truepose.sequencing.errors import NotNowError
from truepose.sequencing.tracker.journal import SessionJournal
from truepose.sequencing.tracker.patience import PatientJournal

_NOT_ON_RECORD: Final = "the database cannot be written now, so this is on record later"
_END_ASKED_FOR: Final = "The end was asked for."


class Standing:
    """The state of one session; every change of it reaches the journal before it is seen."""

    def __init__(
        self, journal: SessionJournal, state: SessionState, end_of_motion: Callable[[], str]
    ) -> None:
        self._direct = journal
        self._end_of_motion = end_of_motion
        self.journal = PatientJournal(journal)  # for the run
        self.state = state
        self.changing = asyncio.Lock()  # transitions reach the journal one after the other
        self.wish: SessionState | None = None  # PAUSING or ABORTING, from the moment it is asked for
        self._wished_by: str | None = None  # who asked for the end, until that is on record
        self.desk = Desk()

    @property
    def trouble(self) -> str | None:
        """What a person is told while records are refused; nothing moves meanwhile."""
        return self.journal.trouble

    @property
    def ends(self) -> bool:
        """Whether the session has ended, or the end was asked for."""
        return has_ended(self.state) or self.wish is SessionState.ABORTING

    def permission(self, _: float) -> Permission:
        """Return what the session says at this moment about motion."""
        return Permission(self.state, self.wish is not None, self.desk.question, self.trouble)

    # what a person asks for

    async def request_pause(self, person: str | None) -> str:
        """Ask for a pause; returns the sentence that says when it takes effect. Raises NotNowError."""
        require_transition(self.state, SessionState.PAUSING)
        earlier, self.wish = self.wish, self.wish or SessionState.PAUSING  # forbids motion from here on
        try:
            async with self.changing:
                await self._record(SessionState.PAUSING, "A pause was asked for.", person)
        except NotNowError:
            self.wish = earlier
            raise
        except RecordRefusedError:
            return f"The session pauses; {self._end_of_motion()}, and {_NOT_ON_RECORD}."
        return f"The session pauses; {self._end_of_motion()}."

    async def request_abort(self, person: str | None) -> str:
        """Ask for the end; returns the sentence that says when it takes effect.

        Raises NotNowError, and RecordRefusedError where nothing is in motion: nothing was done then.
        """
        if has_ended(self.state) or self.state is SessionState.ABORTING:
            raise NotNowError(f"The session is {words(self.state)} already.")
        earlier, self.wish = self.wish, SessionState.ABORTING  # forbids motion from here on
        async with self.changing:
            moving = SessionState.ABORTING in TRANSITIONS[self.state]
            wanted = SessionState.ABORTING if moving else SessionState.ABORTED
            try:
                await self._record(wanted, _END_ASKED_FOR, person)
            except RecordRefusedError:
                if not moving:
                    self.wish = earlier
                    raise
                self._wished_by = person
                return f"The session ends; {self._end_of_motion()}, and {_NOT_ON_RECORD}."
        if moving:
            return f"The session ends; {self._end_of_motion()}."
        self.desk.answer()
        return "The session has ended; nothing was in motion."

    async def go_on(self, from_state: SessionState, verb: str, person: str) -> None:
        """Have the session run; raises NotNowError, PersonMissingError, RecordRefusedError."""
        name = require_person(person)
        async with self.changing:
            if self.state is not from_state or self.desk.question is None:
                raise NotNowError(f"The session is {words(self.state)}; there is nothing to {verb}.")
            await self._record(SessionState.RUNNING, f"{name} had the session go on.", name)
            if self.wish is SessionState.PAUSING:
                self.wish = None
            self.desk.answer()

    # what the run does

    async def put(self, state: SessionState) -> None:
        """Enter `state` with the question that is open."""
        await self.journal.keep(lambda: self._put(state))

    async def finish(self, finished: Callable[[], Progress | None]) -> bool:
        """End the session where `finished` says, with the lock held, how far it is: nothing is left to do."""
        return await self.journal.keep(lambda: self._finish(finished))

    async def end_as_asked(self) -> None:
        """End the session, between two motions."""
        await self.journal.keep(self._end)
        self.desk.answer()

    async def fail(self, reason: str) -> None:
        """End the session as failed."""
        try:
            await self.journal.keep(lambda: self._fail(reason))
        finally:
            self.state = SessionState.FAILED
            self.desk.answer()

    async def _record(self, state: SessionState, reason: str, person: str | None = None) -> None:
        """Change the state; the caller holds the lock."""
        require_transition(self.state, state)
        await self._direct.state_changed(state, reason, person)
        self.state = state

    async def _put(self, state: SessionState) -> None:
        async with self.changing:
            question = self.desk.question
            if question is None:  # answered while this could not be recorded
                return
            if self.state is state:  # after a restart; the question is kept all the same
                await self._direct.state_changed(state, question, None)
            elif self.wish is not SessionState.ABORTING:
                await self._record(state, question)

    async def _finish(self, finished: Callable[[], Progress | None]) -> bool:
        async with self.changing:
            progress = finished()
            if self.wish is not None or progress is None:
                return False
            await self._direct.progressed(progress)
            await self._record(SessionState.FINISHED, "Every configuration was measured or skipped.")
        return True

    async def _end(self) -> None:
        async with self.changing:
            if SessionState.ABORTING in TRANSITIONS[self.state]:  # not on record yet
                await self._record(SessionState.ABORTING, _END_ASKED_FOR, self._wished_by)
            if not has_ended(self.state):
                await self._record(SessionState.ABORTED, "The session ended on request, between two motions.")

    async def _fail(self, reason: str) -> None:
        async with self.changing:
            if not has_ended(self.state):
                await self._direct.state_changed(SessionState.FAILED, reason, None)
