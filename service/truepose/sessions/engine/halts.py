"""Halts hold from the moment at which somebody asks for them, on record or not yet.

A halt must not wait for the disk. One that the ledger refuses holds all the same, in memory, and is kept
under the key of who asked for it as soon as lines are taken again.
"""

from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final

from truepose.domain.errors import RecordRefusedError
from truepose.domain.ledger import EntryKind
from truepose.domain.session import SessionState
from truepose.messages.message import Message, Text, message, together
from truepose.sessions.engine.commands import HALTS, CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.engine.ledger import Logbook
from truepose.sessions.errors import SessionError

_ASKED: Final = {
    CommandName.PAUSE: message("session.pause_asked"),
    CommandName.STOP: message("session.stopped"),
    CommandName.ABORT: message("session.end_asked"),
}
# What whoever asks is told: how the session takes it, and when the arm comes to rest, as parts of a sentence.
_ANSWERS: Final = {
    CommandName.PAUSE: message("session.halt.pauses"),
    CommandName.STOP: message("session.halt.stopped"),
    CommandName.ABORT: message("session.halt.ends"),
}
ENDED_AT_REST = message("session.ended_at_rest")


class Halts:
    """Who asked for what while something may be in motion.

    `end` says when the arm comes to rest that is asked to halt now, as the end of a sentence; `effects` what
    the ledger says where a halt takes effect, by the state that it leads to; else the reason is repeated.
    """

    def __init__(
        self, logbook: Logbook[Any], end: Callable[[], Text], effects: Mapping[SessionState, Text]
    ) -> None:
        self._logbook = logbook
        self._end = end
        self._effects = effects
        self.wish: SessionState | None = None  # what was asked for, from the moment it is asked
        self.moving = False  # something is in motion, or about to be

    @property
    def end(self) -> Text:
        """When the arm comes to rest that is asked to halt now, as the end of a sentence."""
        return self._end()

    def not_on_record(self, act: OperatorCommand) -> Message:
        """Return what is said of a halt that holds and cannot be kept yet."""
        return message("session.halt.not_on_record", halt=_ANSWERS[act.name], end=self.end)

    def forget(self) -> None:
        """Forget a pause or a stop that has taken effect: a person had the session go on."""
        # An end that was asked for is not taken back by a confirmation that somebody sent before they heard
        # of it.
        if self.wish is not SessionState.ABORTED:
            self.wish = None

    async def halt(self, act: OperatorCommand) -> CommandOutcome:
        """Enter the state that is asked for, or have it entered when the motion under way has ended."""
        state, answer = HALTS[act.name], _ANSWERS[act.name]
        reason = together(_ASKED[act.name], act.reason.strip())
        # What is under way cannot be stopped from here: the wish keeps further motions back, and the state
        # follows at the end of this one.
        if self.moving:
            self.wish = state
            between = SessionState.ABORTING if state is SessionState.ABORTED else SessionState.PAUSING
            number = await self._append(between, reason, act)
            return CommandOutcome(message("session.halt.later", halt=answer, end=self.end), number)
        number = await self._halt_at_rest(act, state, reason)
        self.wish = None  # on record from here on
        ended = state is SessionState.ABORTED
        at_rest = message("session.halt.at_rest", halt=answer)
        return CommandOutcome(ENDED_AT_REST if ended else at_rest, number)

    async def _halt_at_rest(self, act: OperatorCommand, state: SessionState, reason: Text) -> int:
        book = self._logbook
        if state is not SessionState.ABORTED:
            return await book.enter(state, self._effects.get(state, reason), act)
        # The table of states leads to the end only through ABORTING; clients that follow events see both.
        if book.state in {SessionState.RUNNING, SessionState.PAUSING}:
            number = await book.enter(SessionState.ABORTING, reason, act)
            await book.enter(state, self._effects.get(state, reason))
            return number
        return await book.enter(state, reason, act)

    async def _append(self, state: SessionState, reason: Text, act: OperatorCommand) -> int:
        return await self._logbook.append(EntryKind.CONTROL, act=act, entered=state, text=reason)

    async def take_effect(self) -> bool:
        """Enter the state that was asked for, at the end of a motion; returns whether one was."""
        book, wish = self._logbook, self.wish
        if wish is None or book.state is SessionState.RUNNING:
            return False  # who asked for it waits for the ledger, and does it
        await book.enter(wish, self._effects.get(wish, book.record.reason))
        self.wish = None
        return True


class PendingHalts:
    """Brings a session to where it waits again after lines were refused.

    `settle` puts what comes next on record, `hold` has the session wait for a person; both hold `changing`.
    """

    def __init__(
        self,
        logbook: Logbook[Any],
        halts: Halts,
        act: Callable[[OperatorCommand], Awaitable[object]],
        settle: Callable[[], Awaitable[None]],
        hold: Callable[[Text], Awaitable[None]],
    ) -> None:
        self._logbook = logbook
        self._halts = halts
        self._act = act
        self._settle = settle
        self._hold = hold
        self.owed: OperatorCommand | None = None

    @property
    def due(self) -> bool:
        """Whether anything waits for the ledger, so that nothing may move."""
        return self.owed is not None or self._logbook.trouble is not None

    def owes(self, act: OperatorCommand) -> bool:
        """Whether an act is the halt that holds without being on record, or its request sent again."""
        owed = self.owed
        # An equal halt without a key is another one: only what was owed is known to hold.
        is_again = owed is not None and act.key is not None and (owed.key, owed.name) == (act.key, act.name)
        return owed is act or is_again

    def owe(self, act: OperatorCommand) -> None:
        """Have a halt hold that was refused; where nothing could move it was not done."""
        # Something may be in motion, so that the halt has to hold. Where the session waits for a person
        # nothing moves anyway: an end that is owed there would come upon a session that somebody has gone on
        # with.
        if self._logbook.state in {SessionState.RUNNING, SessionState.PAUSING}:
            self.owed = act
        else:
            self._halts.wish = None

    async def follow(self) -> None:
        """Keep what is owed and put the next prompt whenever lines are taken again."""
        book = self._logbook
        while True:
            if self.owed is None:
                await book.refused.wait()
            # Before paying, for as long as the disk refuses: a try at each turn would hold the lock that
            # persons' acts need.
            await book.accepted()
            await self._pay()
            await book.keep(self._settle)

    async def _pay(self) -> None:
        while self.owed is not None:
            try:
                await self._act(self.owed)
            except RecordRefusedError:
                await self._logbook.accepted()
                continue
            except SessionError:  # the session is elsewhere by now; it waits for a person all the same
                self._halts.wish = None
                await self._logbook.keep(lambda: self._hold(message("session.halt_asked")))
            if not self._halts.moving and self._logbook.state is SessionState.ABORTING:
                await self._logbook.keep(self._end)  # the second line of an end
            self.owed = None
        self._logbook.tell()

    async def _end(self) -> None:
        await self._halts.take_effect()
