"""What act handlers and loops of a session share: its book, its devices, and the changes that both make.

Every method that appends is called with `changing` held, so that lines reach the ledger one at a time; `keep`
and `note_failure` take it themselves.
"""

from dataclasses import dataclass

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import LengthTaken, StepKind, Suspicion
from truepose.domain.measurement.identities import IdentityTaken
from truepose.domain.measurement.ledger import Control, EntryKind
from truepose.domain.measurement.session import SessionState
from truepose.sequencing.ballbar.arm_at_rest import RestMonitor
from truepose.sequencing.ballbar.doubts.assignments import Judges, doubt
from truepose.sequencing.ballbar.measuring.readings import Readings
from truepose.sequencing.ballbar.motion import Motion
from truepose.sequencing.ballbar.plan import step_ids
from truepose.sequencing.ballbar.situation import Situation
from truepose.sequencing.ballbar.state_so_far import READINGS
from truepose.sequencing.engine.acts import Act
from truepose.sequencing.engine.identity.check import IdentityCheck
from truepose.sequencing.engine.identity.expected import accepted, same_number, sentence
from truepose.sequencing.engine.logbook import Logbook
from truepose.sequencing.errors import ForeignRobotError, NotNowError
from truepose_drivers.errors import DriverError

_PUT_IT_RIGHT = "Put it right."
_SEEN_ON = "The ballbar read a length within its range."
_NO_WAY = "The pre-calibration found no clear way to this pose."


@dataclass(slots=True)
class Transitions:
    """Every way from one situation to the next that is not a reading's or a motion's own."""

    kit: BallbarKit
    judges: Judges
    logbook: Logbook[Situation]
    readings: Readings
    rest: RestMonitor
    motion: Motion
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
        if not self.entered and not await self._enter_cell():
            return
        while self.now.has_no_way and self.now.step is not None:
            await self.logbook.append(EntryKind.SKIPPED, self.now.step.id, text=_NO_WAY)
        if self.now.step is None:
            await self.logbook.enter(SessionState.FINISHED, "Every step is done or was skipped.")
        elif self._prompt_is_due():
            await self.show()

    async def show(self, act: Act | None = None, text: str = "") -> int:
        """Put the present prompt, on record first; returns the number of its line."""
        step = self.now.step
        number = await self.logbook.append(EntryKind.SHOWN, step.id if step else "", act, text=text)
        self.readings.begin_anew()
        if step is not None and step.kind in READINGS:
            self.readings.evidence.expect_length()
        return number

    async def store(self, taken: LengthTaken, act: Act | None = None) -> tuple[int, Suspicion | None]:
        """Keep a length for the present step, or the doubt about it; returns the line and the doubt."""
        await self._require_same_ballbar()
        now, step = self.now, self.now.step
        if step is None:
            return 0, None
        held_for = self.readings.contact.held_for(taken.deviation_mm)
        suspicion = doubt(taken, now, step, self.kit, self.judges, held_for)
        kind = EntryKind.MEASURED if suspicion is None else EntryKind.SUSPECTED
        number = await self.logbook.append(kind, step.id, act, length=taken, suspicion=suspicion)
        self.readings.contact.take(taken.deviation_mm, step.id if suspicion is None else held_for or "")
        self.readings.begin_anew()
        return number, suspicion

    async def hold(self, reason: str) -> None:
        """Have the session wait for a person: something is not as it was left."""
        await self._await_person(f"{_sentence(reason)} {_PUT_IT_RIGHT}")

    async def note_failure(self, error: Exception) -> None:
        """Put a failure on record once lines are taken; else whoever shows it says that nobody runs it."""
        reason = f"The program failed ({type(error).__name__}): {error}"
        try:
            await self.logbook.keep(lambda: self.hold(reason))
        except Exception as second:  # the run ends with the first one: the log must not name another instead
            error.add_note(f"Nor could that be kept ({type(second).__name__}): {second}")

    async def _await_person(self, reason: str) -> None:
        if self.now.state in {SessionState.RUNNING, SessionState.PAUSING}:
            await self.logbook.enter(SessionState.AWAITING_CONFIRMATION, reason)
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
            raise NotNowError(f"Nobody asks whether the ballbar {serial} may measure; nothing was accepted.")
        if not serial:
            raise NotNowError(sentence(foreign))
        await self.identities.keep(accepted(foreign, person))

    async def _require_same_ballbar(self) -> None:
        """See that what a length was read with is still the expected ballbar; raises NotNowError."""
        try:
            await self.readings.ask()
        except DriverError as error:
            raise NotNowError(f"Nothing was stored: {error}") from error
        found = self.ballbar_news() or self.now.ballbar.foreign
        if found is None:
            return
        await self.note_ballbar()
        await self.settle()
        raise NotNowError(f"Nothing was stored. {sentence(found)}")

    async def note_attached(self) -> None:
        """Reopen that the ballbar is off, where a length was seen against it: it is asked for again."""
        step = self.now.step
        if step is not None and step.kind is StepKind.MOVE and not self.now.attached:
            await self.logbook.append(EntryKind.REOPENED, step_ids.detach(step.id), text=_SEEN_ON)

    async def lose_stop(self, reason: str) -> None:
        """Reopen what was done at a stop where the arm no longer stands."""
        if self.now.stop is not None:
            await self.logbook.append(EntryKind.REOPENED, self.now.stop, text=reason)

    async def note_lost_power(self) -> None:
        """Record that the ballbar was without supply, so that its zero is read anew."""
        if self.now.initialisations:
            await self.logbook.append(EntryKind.CONTROL, control=Control.ZERO_LOST)
        self.readings.take_note_of_lost_zero()

    async def look_at_robot(self) -> str | None:
        """Return why the present stop is lost, None where the arm is as it was left; raises driver errors."""
        reading = await self.rest.look()
        arrival = self.now.arrival
        if self.now.stop is None or arrival is None:
            return None
        return self.rest.moved_from(arrival, reading)

    async def require_stop(self, otherwise: str = "Nothing was stored") -> None:
        """See for oneself that the arm still is where it came to rest; raises NotNowError."""
        if self.now.stop is None:
            return
        try:
            moved = await self.look_at_robot()
        except DriverError as error:
            await self.rest.close()
            await self.hold(str(error))
            raise NotNowError(f"{otherwise}: {error}") from error
        if moved is not None:
            await self.lose_stop(moved)
            await self.hold(moved)
            raise NotNowError(f"{otherwise}: {moved}")

    async def _enter_cell(self) -> bool:
        """Open the robot and see whether it stands where the session left it; returns whether it answers."""
        try:
            await self.rest.open()
            await self._meet_robot()
            moved = await self.look_at_robot()
        except DriverError as error:
            await self.rest.close()
            await self.hold(str(error))
            return False
        except ForeignRobotError as error:
            await self.hold(str(error))
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


def _sentence(text: str) -> str:
    """Return `text` with a full stop; drivers' errors come with and without."""
    return text if text.rstrip().endswith((".", "!", "?")) else f"{text.rstrip()}."
