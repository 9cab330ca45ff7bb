"""What happens when a person presses a button: each act is one line of the ledger with its key.

Where an act takes several lines, the one that carries the key comes last: a service that is killed in
between does the whole again when the request is repeated, and nothing twice.
"""

import contextlib
from collections.abc import Awaitable, Callable, Mapping
from typing import Final, TypeAlias

from truepose.domain.ballbar import StepKind, Suspicion, SuspicionKind
from truepose.domain.errors import RecordRefusedError
from truepose.domain.ledger import Control, EntryKind
from truepose.domain.people import tidy_name
from truepose.domain.session import SessionState
from truepose.messages.message import Message, message
from truepose.sessions.ballbar.attachment import NOTHING_KNOWN, STILL_ON
from truepose.sessions.ballbar.length_check import leg_taken_for, legs_to_read_again
from truepose.sessions.ballbar.state import NEEDS_BALLBAR_OFF, Answer
from truepose.sessions.ballbar.transitions import Transitions
from truepose.sessions.engine.commands import HALTS, CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.engine.halts import Halts
from truepose.sessions.engine.prompts import require_person
from truepose.sessions.engine.states import words
from truepose.sessions.errors import NotNowError, ReasonMissingError, WatchingTabletError
from truepose_drivers.api import Clock

Handler: TypeAlias = Callable[[OperatorCommand], Awaitable[CommandOutcome]]

# Whoever stands beside the arm may stop it, and whoever takes over cannot ask the tablet that has gone.
FROM_ANY_TABLET: Final = frozenset({CommandName.STOP, CommandName.HAND_OVER})
_OF_A_STEP: Final = frozenset({
    CommandName.CONFIRM,
    CommandName.STORE,
    CommandName.ANSWER,
    CommandName.RETRY,
    CommandName.SKIP,
    CommandName.BACK,
})
_SEEN_AGE_S: Final = 2.0  # a confirmation that was under way for longer says nothing of the cell now
_ITS_PAIR_CAME: Final = message("session.read_again")
_SUSPICIONS: Final[dict[SuspicionKind, Message]] = {
    "same_pair": message("session.suspicion.same_pair"),
    "other_pair": message("session.suspicion.other_pair"),
    "exchanged": message("session.suspicion.exchanged"),
    "unlikely": message("session.suspicion.unlikely"),
    "calibrator": message("session.suspicion.calibrator"),
    "like_calibrator": message("session.suspicion.like_calibrator"),
    "same_connection": message("session.suspicion.same_connection"),
    "not_calibrator": message("session.suspicion.not_calibrator"),
    "same_bars": message("session.suspicion.same_bars"),
}


class CommandHandlers:
    """Does what acts ask for; called with `changing` held, after `require` let the act pass."""

    def __init__(self, session: Transitions, halts: Halts, clock: Clock) -> None:
        self._session = session
        self._halts = halts
        self._clock = clock
        self._handlers: Mapping[CommandName, Handler] = {
            CommandName.START: self._start,
            CommandName.CONFIRM: self._confirm,
            CommandName.STORE: self._store,
            CommandName.ANSWER: self._answer,
            CommandName.RETRY: self._retry,
            CommandName.SKIP: self._skip,
            CommandName.BACK: self._back,
            CommandName.PAUSE: halts.halt,
            CommandName.RESUME: self._resume,
            CommandName.STOP: halts.halt,
            CommandName.ABORT: halts.halt,
            CommandName.HAND_OVER: self._hand_over,
        }

    def require(self, act: OperatorCommand) -> None:
        """Raise PersonMissingError, WatchingTabletError or NotNowError where the act is not allowed now."""
        # Nobody should have to spell in an emergency (decision 0019).
        if act.name not in HALTS:
            require_person(act.person)
        now = self._session.now
        if now.acting is not None and act.tablet != now.acting.tablet and act.name not in FROM_ANY_TABLET:
            raise WatchingTabletError(message("session.refused.other_tablet", person=now.acting.person))
        present = now.step.id if now.step else None
        # A confirmation that the cell is clear is of no step; one that names its step was meant for that step
        # (decision 0018).
        goes_on = now.state is SessionState.AWAITING_CONFIRMATION and act.step_id is None
        if act.name in _OF_A_STEP and not goes_on and act.step_id != present:
            raise NotNowError(message("session.refused.other_step", step=present or ""))
        if act.name not in now.acts:
            raise NotNowError(message("session.refused.act", state=words(now.state), act=act.name))

    async def do(self, act: OperatorCommand) -> CommandOutcome:
        """Do what an act asks for; raises NotNowError, ReasonMissingError, PlanRefusedError."""
        outcome = await self._handlers[act.name](act)
        with contextlib.suppress(RecordRefusedError):  # the act is kept; the run settles as soon as it can
            await self._session.settle()
        return outcome

    # the course of the session

    async def _start(self, act: OperatorCommand) -> CommandOutcome:
        # At the act and not only when it was planned: limits may have been tightened since (decision 0019).
        self._session.motion.require_plan_within_limits()
        number = await self._session.logbook.append(
            EntryKind.CONTROL,
            act=act,
            entered=SessionState.RUNNING,
            text=message("session.started", person=tidy_name(act.person)),
        )
        return CommandOutcome(message("session.done.begun"), number)

    async def _resume(self, act: OperatorCommand) -> CommandOutcome:
        return await self._go_on(act, "session.resumed")

    async def _go_on(self, act: OperatorCommand, key: str) -> CommandOutcome:
        self._require_may_go_on()
        asked = self._session.now.reason
        number = await self._session.logbook.enter(
            SessionState.RUNNING, message(key, person=tidy_name(act.person)), act
        )
        # Only once the line is on disk: a refused confirmation must not take back a halt.
        self._halts.forget()
        self._session.motion.go_on(asked)
        return CommandOutcome(message("session.done.goes_on"), number)

    def _require_may_go_on(self) -> None:
        # A controller that cannot stop its motion still moves when somebody confirms. Nothing may be sent on
        # top of it.
        if self._halts.moving:
            raise NotNowError(message("session.refused.moves", end=self._halts.end))
        self._session.motion.require_plan_within_limits()

    async def _hand_over(self, act: OperatorCommand) -> CommandOutcome:
        number = await self._session.logbook.append(EntryKind.CONTROL, act=act, control=Control.HAND_OVER)
        return CommandOutcome(message("session.done.hand_over", person=tidy_name(act.person)), number)

    # the present step

    async def _confirm(self, act: OperatorCommand) -> CommandOutcome:
        now = self._session.now
        if now.state is SessionState.AWAITING_CONFIRMATION:
            await self._require_present_look(act)
            self._require_may_go_on()
            await self._session.answer_about_ballbar(act.accepted_serial, tidy_name(act.person))
            return await self._go_on(act, "session.confirmed")
        step = now.step
        if step is not None and step.kind is StepKind.CLAMP_CUP:  # the cup is where the arm holds the ball
            await self._session.require_stop("session.refused.not_clamped")
        if step is None or step.kind not in NEEDS_BALLBAR_OFF:
            return CommandOutcome(message("session.done.done"), await self._keep_confirmed(act))
        word = await self._word_that_it_is_off(act)
        if step.kind is not StepKind.MOVE:
            return CommandOutcome(message("session.done.done"), await self._keep_confirmed(act, word))
        self._session.motion.require_within_limits(step)
        await self._require_present_look(act)
        # Before the line, which lets the motion begin. The other order would have a motion that finds no
        # confirmation.
        self._session.motion.confirmed_s = await self._clock.now_s()
        return CommandOutcome(message("session.done.moves"), await self._keep_confirmed(act, word))

    async def _keep_confirmed(self, act: OperatorCommand, word: str = "") -> int:
        number = await self._session.logbook.append(EntryKind.CONFIRMED, act.step_id or "", act, text=word)
        if word:
            self._session.readings.evidence.believe()
        return number

    async def _word_that_it_is_off(self, act: OperatorCommand) -> str:
        """Return the person's reason where nothing shows that the ballbar is off; "" where samples do.

        What another ballbar shows says nothing of the one that may be attached. Raises NotNowError where a
        length is read, ReasonMissingError.
        """
        evidence, now_s = self._session.readings.evidence, await self._clock.now_s()
        # No reason helps against a length that is read now: the arm once tore down a bar of which somebody
        # had said that it was off (decision 0018).
        if evidence.says(now_s) == "connected":
            raise NotNowError(STILL_ON)
        if not (self._session.now.exchanged or evidence.needs_reason(now_s)):
            return ""
        reason = act.reason.strip()
        if not reason:
            raise ReasonMissingError(NOTHING_KNOWN)
        return reason

    async def _require_present_look(self, act: OperatorCommand) -> None:
        if act.seen_time_s is None:
            return
        age_s = await self._clock.now_s() - act.seen_time_s
        if not abs(age_s) <= _SEEN_AGE_S:
            raise NotNowError(message("session.refused.late_confirmation", age_s=age_s))

    async def _store(self, act: OperatorCommand) -> CommandOutcome:
        # Asked of the robot itself and not of the last look: the length is kept with this place of the arm.
        await self._session.require_stop()
        taken = self._session.readings.length(self._session.now, await self._clock.now_s(), by_hand=True)
        number, suspicion = await self._session.store(taken, act)
        if suspicion is None:
            return CommandOutcome(message("session.done.stored", length_mm=taken.length_mm), number)
        return CommandOutcome(message("session.done.doubted", suspicion=_SUSPICIONS[suspicion.kind]), number)

    async def _answer(self, act: OperatorCommand) -> CommandOutcome:
        suspected = self._session.now.suspicion
        if suspected is None or act.answer not in set(Answer):
            raise NotNowError(message("session.refused.answer"))
        if act.answer != Answer.RIGHT_PAIR:
            return await self._read_again(act, suspected.suspicion)
        # If this pair is right, the earlier leg was read of it by mistake (decision 0025). Reopened first,
        # since the line with the key comes last.
        for step_id in leg_taken_for(self._session.now, suspected.suspicion):
            await self._session.logbook.append(EntryKind.REOPENED, step_id, text=_ITS_PAIR_CAME)
        number = await self._session.logbook.append(
            EntryKind.MEASURED,
            suspected.step_id,
            act,
            length=suspected.length,
            suspicion=suspected.suspicion,
            text=Answer.RIGHT_PAIR.value,
        )
        return CommandOutcome(
            message("session.done.stored_as_asked", length_mm=suspected.length.length_mm), number
        )

    async def _read_again(self, act: OperatorCommand, suspicion: Suspicion) -> CommandOutcome:
        logbook, step = self._session.logbook, self._session.now.step
        answer = act.answer or act.name.value
        of_another_leg = step is not None and step.points not in {None, suspicion.asked}
        if answer == Answer.EXCHANGED or suspicion.kind == "exchanged" or of_another_leg:
            for step_id in legs_to_read_again(self._session.now, suspicion):
                await logbook.append(EntryKind.REOPENED, step_id, text=answer)
        number = await logbook.append(
            EntryKind.ANSWERED, step.id if step else "", act, text=answer, suspicion=suspicion
        )
        return CommandOutcome(message("session.done.read_again"), number)

    async def _retry(self, act: OperatorCommand) -> CommandOutcome:
        suspected = self._session.now.suspicion
        if suspected is not None:
            return await self._read_again(act, suspected.suspicion)
        number = await self._session.show(act, text=CommandName.RETRY.value)
        self._session.readings.let_read_again(act.step_id or "")
        return CommandOutcome(message("session.done.step_again"), number)

    async def _skip(self, act: OperatorCommand) -> CommandOutcome:
        reason = act.reason.strip()
        if not reason:
            raise ReasonMissingError(message("session.refused.skip_reason"))
        number = await self._session.logbook.append(EntryKind.SKIPPED, act.step_id or "", act, text=reason)
        return CommandOutcome(message("session.done.skipped"), number)

    async def _back(self, act: OperatorCommand) -> CommandOutcome:
        session, left = self._session, act.step_id or ""
        sample, contact = session.readings.sample, session.readings.contact
        connected_mm = sample.deviation_mm if sample else None
        number = await session.logbook.append(
            EntryKind.REOPENED, session.now.back_to or "", act, text=act.reason.strip()
        )
        if connected_mm is not None:  # what is connected now is not what the reopened step asks for
            held_for = contact.held_for(connected_mm)
            contact.take(connected_mm, left if held_for is None else held_for)
        return CommandOutcome(message("session.done.back"), number)
