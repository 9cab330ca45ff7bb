"""What act handlers and loops of a session share: its book, its devices, and the changes that both make.

Every method that appends is called with `changing` held, so that lines reach the ledger one at a time; `keep`
and `note_failure` take it themselves.
"""

from dataclasses import dataclass

from truepose.domain.ballbar import LengthTaken, StepKind, Suspicion
from truepose.domain.cell import BallbarKit
from truepose.domain.errors import text_of
from truepose.domain.ledger import Control, EntryKind
from truepose.domain.session import IdentityTaken, SessionState
from truepose.messages.message import Message, Text, as_sentence, message, together
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.length_check import Judges, doubt
from truepose.sessions.ballbar.motion_interlock import InterlockedMotion, RestMonitor
from truepose.sessions.ballbar.readings import Readings
from truepose.sessions.ballbar.situation import Situation
from truepose.sessions.ballbar.state import READINGS
from truepose.sessions.engine.commands import OperatorCommand
from truepose.sessions.engine.identity_check import acceptance_entry, same_number, sentence
from truepose.sessions.engine.ledger import IdentityCheck, Logbook
from truepose.sessions.errors import ForeignRobotError, NotNowError
from truepose_drivers.errors import DriverError

_PUT_IT_RIGHT = message("session.put_right")
_SEEN_ON = message("session.bar.seen_on")
_NO_WAY = message("session.no_way")


@dataclass(slots=True)
class Transitions:
    """Every way from one situation to the next that is not a reading's or a motion's own."""

    kit: BallbarKit
    judges: Judges
    logbook: Logbook[Situation]
    readings: Readings
    rest: RestMonitor
    motion: InterlockedMotion
    identities: IdentityCheck
    entered: bool = False  # the robot was found where it should be since the session last began to run

    @property
    def now(self) -> Situation:
        """The situation as the ledger has it."""
        return self.logbook.situation

    async def settle(self) -> None:
        """Bring the session to where it waits again: robot looked at, next prompt on record, or finished."""
        if self.now.state is not SessionState.RUNNING:
            self.entered = False
            return
        if self.now.ballbar.foreign is not None:
            await self._await_person(sentence(self.now.ballbar.foreign))
            return
        # Whoever goes on after a halt or a restart finds out first whether robot and arm are as they were
        # left.
        if not self.entered and not await self._enter_cell():
            return
        # A loop: several poses in a row may have none.
        while self.now.has_no_way and self.now.step is not None:
            await self.logbook.append(EntryKind.SKIPPED, self.now.step.id, text=_NO_WAY)
        if self.now.step is None:
            await self.logbook.enter(SessionState.FINISHED, message("session.all_done"))
        elif self._prompt_is_due():
            await self.show()

    async def show(self, act: OperatorCommand | None = None, text: Text = "") -> int:
        """Put the present prompt, on record first; returns the number of its line."""
        step = self.now.step
        number = await self.logbook.append(EntryKind.SHOWN, step.id if step else "", act, text=text)
        # What was shown before the prompt is no answer to it.
        self.readings.begin_anew()
        if step is not None and step.kind in READINGS:
            self.readings.evidence.expect_length()
        return number

    async def store(
        self, taken: LengthTaken, act: OperatorCommand | None = None
    ) -> tuple[int, Suspicion | None]:
        """Keep a length for the present step, or the doubt about it; returns the line and the doubt."""
        # Asked just before it is kept: a bar that was exchanged behind its link has given the whole length
        # (decision 0020).
        await self._require_same_ballbar()
        now, step = self.now, self.now.step
        if step is None:
            return 0, None
        held_for = self.readings.contact.held_for(taken.deviation_mm)
        suspicion = doubt(taken, now, step, self.kit, self.judges, held_for)
        kind = EntryKind.MEASURED if suspicion is None else EntryKind.SUSPECTED
        number = await self.logbook.append(kind, step.id, act, length=taken, suspicion=suspicion)
        # Only after the line is kept: a length that is refused has to be stored by itself once lines are
        # taken.
        self.readings.contact.take(taken.deviation_mm, step.id if suspicion is None else held_for or "")
        self.readings.begin_anew()
        return number, suspicion

    async def hold(self, reason: Text) -> None:
        """Have the session wait for a person: something is not as it was left."""
        await self._await_person(together(as_sentence(reason), _PUT_IT_RIGHT))

    async def note_failure(self, error: Exception) -> None:
        """Put a failure on record once lines are taken; else whoever shows it says that nobody runs it."""
        reason = message("session.program_failed", kind=type(error).__name__, why=text_of(error))
        try:
            await self.logbook.keep(lambda: self.hold(reason))
        except Exception as second:  # the run ends with the first one: the log must not name another instead
            error.add_note(f"The error could not be saved either ({type(second).__name__}): {second}")

    async def _await_person(self, reason: Text) -> None:
        if self.now.state in {SessionState.RUNNING, SessionState.PAUSING}:
            await self.logbook.enter(SessionState.AWAITING_CONFIRMATION, reason)
        # Somebody has asked for the end: it must not become a question.
        elif self.now.state is SessionState.ABORTING:
            await self.logbook.enter(SessionState.ABORTED, reason)
        self.entered = False

    def ballbar_news(self) -> IdentityTaken | None:
        """Return what is new about the ballbar; None where it is the one that is expected."""
        return self.identities.news("ballbar", self.readings.identity)

    async def note_ballbar(self) -> None:
        """Put on record which ballbar answers; what it showed before, and from where it counts, is void."""
        found = self.ballbar_news()
        if found is None:
            return
        asked = self.now.ballbar.foreign is not None
        await self.identities.keep(found)
        self.readings.begin_anew()
        if self.now.initialisations:
            self.readings.take_note_of_lost_zero()
        if self.now.state is SessionState.AWAITING_CONFIRMATION and (asked or found.finding == "foreign"):
            state = SessionState.AWAITING_CONFIRMATION  # another question from now on
            await self.logbook.append(EntryKind.CONTROL, entered=state, text=sentence(found))

    async def answer_about_ballbar(self, serial: str, person: str) -> None:
        """Accept the ballbar of this serial number where it is in question.

        Raises NotNowError where another one is, or where one is and no number was given.
        """
        foreign = self.now.ballbar.foreign
        if foreign is None and not serial:
            return
        if foreign is None or (serial and not same_number(serial, foreign.serial)):
            raise NotNowError(message("session.refused.ballbar_not_asked", serial=serial))
        if not serial:
            # A confirmation without a number may be one that was meant for the question before, or was sent
            # twice: it accepts nothing.
            raise NotNowError(sentence(foreign))
        await self.identities.keep(acceptance_entry(foreign, person))

    async def _require_same_ballbar(self) -> None:
        """See that what a length was read with is still the expected ballbar; raises NotNowError."""
        try:
            await self.readings.ask()
        except DriverError as error:
            raise NotNowError(message("session.refused.not_stored", why=text_of(error))) from error
        found = self.ballbar_news() or self.now.ballbar.foreign
        if found is None:
            return
        await self.note_ballbar()
        await self.settle()
        raise NotNowError(message("session.refused.nothing_stored", sentence=sentence(found)))

    async def note_attached(self) -> None:
        """Reopen that the ballbar is off, where a length was seen against it: it is asked for again."""
        step = self.now.step
        if step is not None and step.kind is StepKind.MOVE and not self.now.attached:
            await self.logbook.append(EntryKind.REOPENED, step_ids.detach(step.id), text=_SEEN_ON)

    async def lose_stop(self, reason: Text) -> None:
        """Reopen what was done at a stop where the arm no longer stands."""
        if self.now.stop is not None:
            await self.logbook.append(EntryKind.REOPENED, self.now.stop, text=reason)

    async def note_lost_power(self) -> None:
        """Record that the ballbar was without supply, so that its zero is read anew."""
        if self.now.initialisations:
            await self.logbook.append(EntryKind.CONTROL, control=Control.ZERO_LOST)
        self.readings.take_note_of_lost_zero()

    async def look_at_robot(self) -> Message | None:
        """Return why the present stop is lost, None where the arm is as it was left; raises driver errors."""
        reading = await self.rest.look()
        arrival = self.now.arrival
        if self.now.stop is None or arrival is None:
            return None
        return self.rest.moved_from(arrival, reading)

    async def require_stop(self, otherwise: str = "session.refused.not_stored") -> None:
        """See for oneself that the arm still is where it came to rest; raises NotNowError."""
        if self.now.stop is None:
            return
        try:
            moved = await self.look_at_robot()
        except DriverError as error:
            await self.rest.close()
            await self.hold(text_of(error))
            raise NotNowError(message(otherwise, why=text_of(error))) from error
        if moved is not None:
            await self.lose_stop(moved)
            await self.hold(moved)
            raise NotNowError(message(otherwise, why=moved))

    async def _enter_cell(self) -> bool:
        """Open the robot and see whether it stands where the session left it; returns whether it answers."""
        try:
            await self.rest.open()
            # At every opening: a controller that was switched off has forgotten its limits.
            await self.motion.set_speed()
            await self._meet_robot()
            moved = await self.look_at_robot()
        except DriverError as error:
            await self.rest.close()
            await self.hold(text_of(error))
            return False
        except ForeignRobotError as error:
            await self.hold(text_of(error))
            return False
        if moved is not None:
            await self.lose_stop(moved)
        self.entered = True
        return True

    async def _meet_robot(self) -> None:
        """Ask the robot who it is; raises ForeignRobotError, the driver's errors."""
        identity = await self.rest.who()
        self.identities.hear("robot", identity)
        found = self.identities.news("robot", identity)
        if found is not None:
            await self.identities.keep(found)
        if self.now.robot.foreign is not None:
            raise ForeignRobotError(sentence(self.now.robot.foreign))

    def _prompt_is_due(self) -> bool:
        now = self.now
        if now.shown or now.confirmed or now.suspicion is not None or now.step is None:
            return False
        return now.step.kind is not StepKind.PRECALIBRATE
