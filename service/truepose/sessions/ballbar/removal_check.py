"""Whether a session without the ballbar may move the arm: the bar may hang where an earlier session left it.

A session with the ballbar that is ended early asks nobody to take it off. Whoever confirms the next one looks
at a cell in which they expect no ballbar; so the bar is asked, where there is one that answers. Where what is
on record leaves it attached, unknown counts as attached, as in a session with the ballbar: it must be seen to
come off, or a person says how they know, on the record of the session that they confirm.
"""

import contextlib
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Final, TypeAlias

from truepose.domain.cell import BallbarKit
from truepose.domain.ledger import BALLBAR_OFF, BALLBAR_ON
from truepose.messages.message import Text, message
from truepose.sessions.ballbar.attachment import NOTHING_KNOWN, AttachmentEvidence
from truepose.sessions.ballbar.live import Seen
from truepose.sessions.ballbar.state import leaves_attached
from truepose.sessions.devices import DeviceRegistry
from truepose.sessions.engine.commands import OperatorCommand
from truepose.sessions.errors import MissingDeviceError, NotNowError, ReasonMissingError
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose_drivers.api import Ballbar
from truepose_drivers.errors import DriverError

Note: TypeAlias = Callable[[int, str, Text], Awaitable[None]]  # session, step of the line, sentence

_SAMPLES: Final = 12  # enough to see that it is off, or that it does not move as in a hand
_EVERY_S: Final = 0.05
_LEFT_ON: Final = message("session.bar.left_on")
_READ: Final = message("session.bar.seen_on")
_SEEN_OFF: Final = message("session.bar.seen_off")


class BarPutAway:
    """Judges confirmations of sessions without the ballbar by the bar in their cell."""

    def __init__(
        self, sessions: SessionRepository, ledger: LedgerRepository, rack: DeviceRegistry, note: Note
    ) -> None:
        """Judge by these records; `note` puts a sentence on record of a session, whoever runs it."""
        self._sessions = sessions
        self._ledger = ledger
        self._rack = rack
        self._note = note
        self._followed: tuple[int, AttachmentEvidence] | None = None  # since the session was first confirmed

    async def judged(self, session_id: int, act: OperatorCommand) -> OperatorCommand:
        """Return an act with why the ballbar counts as off, where that is to be put on record.

        Raises NotNowError where it reads a length; ReasonMissingError where it may be attached, was not seen
        to come off, and nobody says how they know.
        """
        try:
            ballbar = self._rack.ballbar
        # A cell without a ballbar has none that could hang in it.
        except MissingDeviceError:
            return act
        setup = await self._sessions.setup(session_id)
        seen = await self._looked_at(ballbar, self._evidence(session_id, setup.cell.ballbar))
        left_on = await self._left_attached(simulated=setup.simulated)
        # Whatever is on record: a length that is read now is a bar between two balls, or on its calibrator.
        if seen == "connected":
            # Kept, so that the next confirmation, or another session, knows of it although the bar may have
            # fallen silent.
            if not left_on:
                await self._note(session_id, BALLBAR_ON, _READ)
            raise NotNowError(_LEFT_ON)
        return replace(act, ballbar_off=_why_off(seen, act)) if left_on else act

    def _evidence(self, session_id: int, kit: BallbarKit | None) -> AttachmentEvidence:
        """Return what was seen of it since the session was first confirmed."""
        if self._followed is None or self._followed[0] != session_id:
            self._followed = session_id, AttachmentEvidence((kit or BallbarKit()).range_mm)
        return self._followed[1]

    async def _looked_at(self, ballbar: Ballbar, evidence: AttachmentEvidence) -> Seen:
        was_open = ballbar.connected
        try:
            return await self._sampled(ballbar, evidence)
        except DriverError:
            # An error is silence, and silence proves nothing.
            evidence.note(None, None)
            return "unknown"
        finally:
            # A link that was open is somebody's; one that was opened for this question is closed again.
            if not was_open:
                with contextlib.suppress(DriverError):
                    await ballbar.close()

    async def _sampled(self, ballbar: Ballbar, evidence: AttachmentEvidence) -> Seen:
        if not ballbar.connected:
            await ballbar.connect()
        for _ in range(_SAMPLES):
            reading = await ballbar.read()
            evidence.note(reading, reading.deviation_mm)  # nobody knows another zero than its own
            await self._rack.clock.sleep(_EVERY_S)
        return evidence.says(reading.time_s)

    async def _left_attached(self, *, simulated: bool) -> bool:
        """Whether what is on record last leaves it attached: of a session with it, or noted since."""
        noted = await self._ledger.newest_at(BALLBAR_OFF, BALLBAR_ON, simulated=simulated)
        for number in await self._sessions.with_ballbar(simulated=simulated):
            lines = await self._ledger.whole(number)
            attached = leaves_attached(line.entry for line in lines)
            # A session that was planned and never asked for the bar says nothing of it; the one before does.
            if attached is None:
                continue
            # Numbers of lines are given in the order of commits over all sessions, so they say which came
            # last.
            if noted is None or noted.id < lines[-1].id:
                return attached
            break
        return noted is not None and noted.entry.step_id == BALLBAR_ON


def _why_off(seen: Seen, act: OperatorCommand) -> Text:
    if seen != "unknown":
        return _SEEN_OFF
    reason = act.reason.strip()
    if not reason:
        raise ReasonMissingError(NOTHING_KNOWN)
    return message("session.bar.said_off", person=act.person, reason=reason)
