"""A halt holds from the moment at which somebody asks for it, whether or not it is on record yet."""

from collections.abc import Callable, Mapping
from typing import Any

from truepose.domain.measurement.ledger import EntryKind
from truepose.domain.measurement.session import SessionState
from truepose.sequencing.engine.acts import HALTS, Act, ActName, ActOutcome
from truepose.sequencing.engine.logbook import Logbook

_ASKED = {
    ActName.PAUSE: ("A pause was asked for.", "The session pauses"),
    ActName.STOP: ("Stop was pressed.", "The session has stopped"),
    ActName.ABORT: ("The end was asked for.", "The session ends"),
}
_NOT_ON_RECORD = "the database cannot be written now, so this is on record later"
ENDED_AT_REST = "The session has ended; nothing was in motion."


class Halts:
    """Who asked for what while something may be in motion.

    `end` says when the arm comes to rest that is asked to halt now, as the end of a sentence; `effects` what
    the ledger says where a halt takes effect, by the state that it leads to; else the reason is repeated.
    """

    def __init__(
        self, logbook: Logbook[Any], end: Callable[[], str], effects: Mapping[SessionState, str]
    ) -> None:
        self._logbook = logbook
        self._end = end
        self._effects = effects
        self.wish: SessionState | None = None  # what was asked for, from the moment it is asked
        self.moving = False  # something is in motion, or about to be

    @property
    def end(self) -> str:
        """When the arm comes to rest that is asked to halt now, as the end of a sentence."""
        return self._end()

    def not_on_record(self, act: Act) -> str:
        """Return what is said of a halt that holds and cannot be kept yet."""
        return f"{_ASKED[act.name][1]}; {self.end}, and {_NOT_ON_RECORD}."

    def forget(self) -> None:
        """Forget a pause or a stop that has taken effect: a person had the session go on."""
        if self.wish is not SessionState.ABORTED:
            self.wish = None

    async def halt(self, act: Act) -> ActOutcome:
        """Enter the state that is asked for, or have it entered when the motion under way has ended."""
        state, (asked, sentence) = HALTS[act.name], _ASKED[act.name]
        reason = f"{asked} {act.reason.strip()}".strip()
        if self.moving:
            self.wish = state
            between = SessionState.ABORTING if state is SessionState.ABORTED else SessionState.PAUSING
            number = await self._append(between, reason, act)
            return ActOutcome(f"{sentence}; {self.end}.", number)
        number = await self._halt_at_rest(act, state, reason)
        self.wish = None  # on record from here on
        ended = state is SessionState.ABORTED
        return ActOutcome(ENDED_AT_REST if ended else f"{sentence}; nothing is in motion.", number)

    async def _halt_at_rest(self, act: Act, state: SessionState, reason: str) -> int:
        book = self._logbook
        if state is not SessionState.ABORTED:
            return await book.enter(state, self._effects.get(state, reason), act)
        if book.state in {SessionState.RUNNING, SessionState.PAUSING}:
            number = await book.enter(SessionState.ABORTING, reason, act)
            await book.enter(state, self._effects.get(state, reason))
            return number
        return await book.enter(state, reason, act)

    async def _append(self, state: SessionState, reason: str, act: Act) -> int:
        return await self._logbook.append(EntryKind.CONTROL, act=act, entered=state, text=reason)

    async def take_effect(self) -> bool:
        """Enter the state that was asked for, at the end of a motion; returns whether one was."""
        book, wish = self._logbook, self.wish
        if wish is None or book.state is SessionState.RUNNING:
            return False  # who asked for it waits for the ledger, and does it
        await book.enter(wish, self._effects.get(wish, book.record.reason))
        self.wish = None
        return True
