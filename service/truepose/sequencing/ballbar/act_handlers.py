"""What happens when a person presses a button: each act is one line of the ledger with its key.

Where an act takes several lines, the one that carries the key comes last: a service that is killed in
between does the whole again when the request is repeated, and nothing twice.
"""

import contextlib
from collections.abc import Awaitable, Callable, Mapping
from typing import Final, TypeAlias

from truepose.domain.errors import RecordRefusedError
from truepose.domain.measurement.ballbar import StepKind, Suspicion, SuspicionKind
from truepose.domain.measurement.ledger import Control, EntryKind
from truepose.domain.measurement.session import SessionState
from truepose.domain.people.names import tidy_name
from truepose.sequencing.ballbar.acts import Answer
from truepose.sequencing.ballbar.doubts.assignments import leg_taken_for, legs_to_read_again
from truepose.sequencing.ballbar.measuring.attachment import NOTHING_KNOWN, STILL_ON
from truepose.sequencing.ballbar.state_so_far import NEEDS_BALLBAR_OFF
from truepose.sequencing.ballbar.transitions import Transitions
from truepose.sequencing.engine.acts import HALTS, Act, ActName, ActOutcome
from truepose.sequencing.engine.halting.halts import Halts
from truepose.sequencing.engine.prompts import require_person
from truepose.sequencing.engine.states import words
from truepose.sequencing.errors import NotNowError, ReasonMissingError, WatchingTabletError
from truepose_drivers.api import Clock

Handler: TypeAlias = Callable[[Act], Awaitable[ActOutcome]]

FROM_ANY_TABLET: Final = frozenset({ActName.STOP, ActName.HAND_OVER})
_OF_A_STEP: Final = frozenset({
    ActName.CONFIRM,
    ActName.STORE,
    ActName.ANSWER,
    ActName.RETRY,
    ActName.SKIP,
    ActName.BACK,
})
_SEEN_AGE_S: Final = 2.0  # a confirmation that was under way for longer says nothing of the cell now
_ITS_PAIR_CAME: Final = "It may have been read of the pair that came now; it is read once more."
_SUSPICIONS: Final[dict[SuspicionKind, str]] = {
    "same_pair": "this looks like a pair that was read already",
    "other_pair": "this looks like another pair than the one asked for",
    "exchanged": "two legs seem to be exchanged",
    "unlikely": "this is far from what was to be expected",
    "calibrator": "the ballbar seems to be on the calibrator still",
    "same_connection": "the ballbar was not let go since a length was read that is not this one",
    "not_calibrator": "this is no length of the calibrator, or the zero before was none",
    "same_bars": "this is the zero of the other bars",
}


class ActHandlers:
    """Does what acts ask for; called with `changing` held, after `require` let the act pass."""

    def __init__(self, session: Transitions, halts: Halts, clock: Clock) -> None:
        self._session = session
        self._halts = halts
        self._clock = clock
        self._handlers: Mapping[ActName, Handler] = {
            ActName.START: self._start,
            ActName.CONFIRM: self._confirm,
            ActName.STORE: self._store,
            ActName.ANSWER: self._answer,
            ActName.RETRY: self._retry,
            ActName.SKIP: self._skip,
            ActName.BACK: self._back,
            ActName.PAUSE: halts.halt,
            ActName.RESUME: self._resume,
            ActName.STOP: halts.halt,
            ActName.ABORT: halts.halt,
            ActName.HAND_OVER: self._hand_over,
        }

    def require(self, act: Act) -> None:
        """Raise PersonMissingError, WatchingTabletError or NotNowError where the act is not allowed now."""
        if act.name not in HALTS:
            require_person(act.person)
        now = self._session.now
        if now.acting is not None and act.tablet != now.acting.tablet and act.name not in FROM_ANY_TABLET:
            raise WatchingTabletError(f"{now.acting.person} acts on another tablet; take over there first.")
        present = now.step.id if now.step else None
        goes_on = now.state is SessionState.AWAITING_CONFIRMATION and act.step_id is None
        if act.name in _OF_A_STEP and not goes_on and act.step_id != present:
            raise NotNowError(f"The session is at the step {present} by now; nothing was done.")
        if act.name not in now.acts:
            raise NotNowError(f"The session is {words(now.state)}; '{act.name}' cannot be done now.")

    async def do(self, act: Act) -> ActOutcome:
        """Do what an act asks for; raises NotNowError, ReasonMissingError, PlanRefusedError."""
        outcome = await self._handlers[act.name](act)
        with contextlib.suppress(RecordRefusedError):  # the act is kept; the run settles as soon as it can
            await self._session.settle()
        return outcome

    # the course of the session

    async def _start(self, act: Act) -> ActOutcome:
        self._session.motion.require_plan_within_limits()
        number = await self._session.logbook.append(
            EntryKind.CONTROL,
            act=act,
            entered=SessionState.RUNNING,
            text=f"{tidy_name(act.person)} started the session.",
        )
        return ActOutcome("The session has begun.", number)

    async def _resume(self, act: Act) -> ActOutcome:
        return await self._go_on(act, "resumed the session")

    async def _go_on(self, act: Act, what: str) -> ActOutcome:
        self._require_may_go_on()
        number = await self._session.logbook.enter(
            SessionState.RUNNING, f"{tidy_name(act.person)} {what}.", act
        )
        self._halts.forget()
        self._session.motion.forget()
        return ActOutcome("The session goes on at the step where it was.", number)

    def _require_may_go_on(self) -> None:
        if self._halts.moving:
            raise NotNowError(f"The robot still moves; {self._halts.end}.")
        self._session.motion.require_plan_within_limits()

    async def _hand_over(self, act: Act) -> ActOutcome:
        number = await self._session.logbook.append(EntryKind.CONTROL, act=act, control=Control.HAND_OVER)
        return ActOutcome(f"{tidy_name(act.person)} acts on this tablet from now on.", number)

    # the present step

    async def _confirm(self, act: Act) -> ActOutcome:
        now = self._session.now
        if now.state is SessionState.AWAITING_CONFIRMATION:
            await self._require_present_look(act)
            self._require_may_go_on()
            await self._session.answer_about_ballbar(act.accepted_serial, tidy_name(act.person))
            return await self._go_on(act, "confirmed that the cell is clear")
        step = now.step
        if step is not None and step.kind is StepKind.CLAMP_CUP:  # the cup is where the arm holds the ball
            await self._session.require_stop("The cup does not count as clamped")
        if step is None or step.kind not in NEEDS_BALLBAR_OFF:
            return ActOutcome("Done.", await self._keep_confirmed(act))
        word = await self._word_that_it_is_off(act)
        if step.kind is not StepKind.MOVE:
            return ActOutcome("Done.", await self._keep_confirmed(act, word))
        self._session.motion.require_within_limits(step)
        await self._require_present_look(act)
        self._session.motion.confirmed_s = await self._clock.now_s()
        return ActOutcome("Confirmed; the robot moves.", await self._keep_confirmed(act, word))

    async def _keep_confirmed(self, act: Act, word: str = "") -> int:
        number = await self._session.logbook.append(EntryKind.CONFIRMED, act.step_id or "", act, text=word)
        if word:
            self._session.readings.evidence.believe()
        return number

    async def _word_that_it_is_off(self, act: Act) -> str:
        """Return the person's reason where nothing shows that the ballbar is off; "" where samples do.

        What another ballbar shows says nothing of the one that may be attached. Raises NotNowError where a
        length is read, ReasonMissingError.
        """
        evidence, now_s = self._session.readings.evidence, await self._clock.now_s()
        if evidence.says(now_s) == "connected":
            raise NotNowError(STILL_ON)
        if not (self._session.now.exchanged or evidence.needs_reason(now_s)):
            return ""
        reason = act.reason.strip()
        if not reason:
            raise ReasonMissingError(NOTHING_KNOWN)
        return reason

    async def _require_present_look(self, act: Act) -> None:
        if act.seen_time_s is None:
            return
        age_s = await self._clock.now_s() - act.seen_time_s
        if not abs(age_s) <= _SEEN_AGE_S:
            raise NotNowError(
                f"The confirmation was under way for {age_s:.1f} s; look at the cell and confirm anew."
            )

    async def _store(self, act: Act) -> ActOutcome:
        await self._session.require_stop()
        taken = self._session.readings.length(self._session.now, await self._clock.now_s(), by_hand=True)
        number, suspicion = await self._session.store(taken, act)
        if suspicion is None:
            return ActOutcome(f"Stored: {taken.length_mm:.4f} mm.", number)
        return ActOutcome(f"Not stored yet: {_SUSPICIONS[suspicion.kind]}.", number)

    async def _answer(self, act: Act) -> ActOutcome:
        suspected = self._session.now.suspicion
        if suspected is None or act.answer not in set(Answer):
            raise NotNowError("The answer must be one of right_pair, reconnected, exchanged.")
        if act.answer != Answer.RIGHT_PAIR:
            return await self._read_again(act, suspected.suspicion)
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
        return ActOutcome(f"Stored as asked for: {suspected.length.length_mm:.4f} mm.", number)

    async def _read_again(self, act: Act, suspicion: Suspicion) -> ActOutcome:
        logbook, step = self._session.logbook, self._session.now.step
        answer = act.answer or act.name.value
        of_another_leg = step is not None and step.points not in {None, suspicion.asked}
        if answer == Answer.EXCHANGED or suspicion.kind == "exchanged" or of_another_leg:
            for step_id in legs_to_read_again(self._session.now, suspicion):
                await logbook.append(EntryKind.REOPENED, step_id, text=answer)
        number = await logbook.append(
            EntryKind.ANSWERED, step.id if step else "", act, text=answer, suspicion=suspicion
        )
        return ActOutcome("Not stored; it is read again.", number)

    async def _retry(self, act: Act) -> ActOutcome:
        suspected = self._session.now.suspicion
        if suspected is not None:
            return await self._read_again(act, suspected.suspicion)
        number = await self._session.show(act, text=ActName.RETRY.value)
        self._session.readings.let_read_again(act.step_id or "")
        return ActOutcome("The step begins again.", number)

    async def _skip(self, act: Act) -> ActOutcome:
        reason = act.reason.strip()
        if not reason:
            raise ReasonMissingError("A skip needs its reason: it is kept in place of the reading.")
        number = await self._session.logbook.append(EntryKind.SKIPPED, act.step_id or "", act, text=reason)
        return ActOutcome("Skipped; what is read already stays.", number)

    async def _back(self, act: Act) -> ActOutcome:
        session, left = self._session, act.step_id or ""
        sample, contact = session.readings.sample, session.readings.contact
        connected_mm = sample.deviation_mm if sample else None
        number = await session.logbook.append(
            EntryKind.REOPENED, session.now.back_to or "", act, text=act.reason.strip()
        )
        if connected_mm is not None:  # what is connected now is not what the reopened step asks for
            held_for = contact.held_for(connected_mm)
            contact.take(connected_mm, left if held_for is None else held_for)
        return ActOutcome("Back; what was kept there counts no more.", number)
