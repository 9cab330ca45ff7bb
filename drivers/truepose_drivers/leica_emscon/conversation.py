"""The conversation with an emScon server: one request at a time, its answer among whatever else arrives.

A refusal or a failed measurement is an answer; whatever else breaks an exchange off closes the link.

Turning the head takes seconds, starting up minutes, and nothing comes meanwhile. A tracker that is silent for
a second is asked for its status: it says that it is busy, or the link is lost. One that tells its status and
has not answered a question that takes no time will not do so any more: commands are answered in their order.
"""

from dataclasses import dataclass
from typing import Final

from truepose_drivers.errors import DeviceRefusedError, MeasurementFailedError, NoReplyError
from truepose_drivers.leica_emscon import protocol
from truepose_drivers.leica_emscon.error_codes import Purpose, command_name, concerns_connection, error_for
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link

_MOST_ITEMS = 1_000  # of a list; a tracker stores a few dozen reflectors
_QUIET_S: Final = 0.9  # without a packet, before the tracker is asked, and then before it is given up
_TAKE_TIME: Final = frozenset({
    protocol.Command.INITIALIZE,
    protocol.Command.GO_POSITION,
    protocol.Command.FIND_REFLECTOR,
    protocol.Command.CHANGE_FACE,
})
_SIGN_OF_LIFE: Final = protocol.Request(protocol.Command.GET_TRACKER_STATUS)


@dataclass(frozen=True, slots=True)
class Subject:
    """What is measured: the packets of its results, and what a status means while it is."""

    results: frozenset[protocol.PacketType]
    purpose: Purpose


class TrackerConversation:
    """Requests and answers on one link; unasked packets in between are digested."""

    def __init__(self, link: Link, subject: Subject) -> None:
        self._subject = subject
        self._frames: Conversation[protocol.Frame] = Conversation(
            link, protocol.FrameReader, harmless=(DeviceRefusedError, MeasurementFailedError)
        )
        self._changes: set[int] = set()
        self._owes_sign = False  # of life, that was asked for
        self._takes_time = False  # what is awaited
        self.answers_while_busy = True  # False: it keeps what it is asked until it is done

    async def open(self) -> None:
        """Open the link afresh; raises ConnectFailedError."""
        self._changes = set()
        self._owes_sign = False
        self.answers_while_busy = True
        await self._frames.open()

    async def ask(
        self, request: protocol.Request, *, timeout_s: float, purpose: Purpose = "set"
    ) -> protocol.Record:
        """Return the members of the answer; raises the error that its status means."""
        async with self._frames.turn():
            await self._send(request, timeout_s)
            values = await self._answer(request.command, purpose)
            await self._digest_pending(after_answer=True)
            return values

    async def ask_list(self, command: protocol.Command, *, timeout_s: float) -> list[protocol.Record]:
        """Return the items of a list command, which come one a packet; may be empty."""
        async with self._frames.turn():
            await self._send(protocol.Request(command), timeout_s)
            items = [await self._answer(command, "set")]
            total = items[0].integer(next(iter(items[0])))  # every item carries the total first
            if not 0 <= total <= _MOST_ITEMS:
                raise protocol.PacketError(f"the tracker announces {total} items for {command_name(command)}")
            while len(items) < total:
                items.append(await self._answer(command, "set"))
            return items[:total]

    async def measure(self, *, accept_s: float, result_s: float) -> protocol.Record:
        """Start a stationary measurement and return the members of its result.

        A result that arrives before the answer was under way before we asked: it is not ours.
        """
        request, purpose = protocol.Request(protocol.Command.START_MEASUREMENT), self._subject.purpose
        async with self._frames.turn():
            await self._send(request, accept_s)
            await self._answer(request.command, purpose, about_anything=True)
            self._expect(request.command, result_s)
            self._takes_time = True
            result = await self._result()
            if result.status != protocol.ResultStatus.ALL_OK:
                raise error_for(request.command, result.status, purpose)
            await self._digest_pending(after_answer=True)
            return result.values

    async def _result(self) -> protocol.Result:
        while True:
            match await self._next_packet():
                case protocol.ErrorReport(_, status):  # nothing else is active that it could be about
                    raise error_for(protocol.Command.START_MEASUREMENT, status, self._subject.purpose)
                case protocol.Result(kind) as result if kind in self._subject.results:
                    return result

    def take_changes(self) -> frozenset[int]:
        """Return what the tracker has announced since this was asked last (SystemStatusChange)."""
        changes, self._changes = frozenset(self._changes), set()
        return changes

    async def _send(self, request: protocol.Request, timeout_s: float) -> None:
        """Send a request whose answers are awaited from now on."""
        await self._digest_pending()
        self._expect(request.command, timeout_s)
        self._takes_time = request.command in _TAKE_TIME
        await self._frames.add(protocol.encode(request))

    def _expect(self, command: int, timeout_s: float) -> None:
        silence = (
            f"the tracker at {self._frames.address} did not answer {command_name(command)} in time:"
            " check that it is still running, then connect again"
        )
        self._frames.expect(timeout_s, silence)

    async def _digest_pending(self, *, after_answer: bool = False) -> None:
        """Read what arrived unasked, so that it is not taken for news.

        Right after an answer nothing may stand there that answers: nobody knows which of them is ours.
        """
        async for frame in self._frames.arrived():
            packet = self._take(frame)
            if self._is_sign_of_life(packet):
                continue
            if after_answer and self._answers(packet):
                raise protocol.PacketError(
                    f"the tracker at {self._frames.address} sent more data than requested: connect again"
                )

    async def _answer(
        self, command: int, purpose: Purpose, *, about_anything: bool = False
    ) -> protocol.Record:
        """Return what a command is answered with, where an error may be `about_anything` or names it."""
        while True:
            match await self._next_packet():
                case protocol.Answer(answered, status, values) if answered == command:
                    if status != protocol.ResultStatus.ALL_OK:
                        raise error_for(command, status, purpose)
                    return values
                # An error packet may stand in place of an answer; what it names is the command that was
                # active, which need not be the one that was asked.
                case protocol.ErrorReport(active, status) if about_anything or active == command:
                    raise error_for(command, status, purpose)

    async def _next_packet(self) -> protocol.FromServer:
        """Return the next packet that is no sign of life."""
        while True:
            frame = await self._frames.next_within(_QUIET_S)
            if frame is None:
                await self._ask_for_sign_of_life()
                continue
            packet = self._take(frame)
            if not self._is_sign_of_life(packet):
                return packet
            if not self._takes_time and _is_at_leisure(packet):
                raise NoReplyError(
                    f"the tracker at {self._frames.address} is connected, but its answer was lost: connect"
                    " again"
                )

    async def _ask_for_sign_of_life(self) -> None:
        # With its queue of commands on it would answer only when it is done: silence tells nothing there.
        if not self.answers_while_busy:
            return
        if self._owes_sign:
            raise NoReplyError(
                f"the tracker at {self._frames.address} has stopped sending, even its busy messages:"
                " check its power and cable, then connect again"
            )
        self._owes_sign = True
        await self._frames.add(protocol.encode(_SIGN_OF_LIFE))

    def _answers(self, packet: protocol.FromServer) -> bool:
        return isinstance(packet, protocol.Answer) or (
            isinstance(packet, protocol.Result) and packet.packet_type in self._subject.results
        )

    def _is_sign_of_life(self, packet: protocol.FromServer) -> bool:
        """Whether a packet is the answer owed to our asking in between, of whatever status."""
        is_owed = self._owes_sign and _is_about(packet, _SIGN_OF_LIFE.command)
        if is_owed:
            self._owes_sign = False
        return is_owed

    def _take(self, frame: protocol.Frame) -> protocol.FromServer:
        packet = protocol.decode_from_server(frame)
        # Comes unasked and for whatever command is under way: the tracker is gone, or another program has it.
        if isinstance(packet, protocol.ErrorReport) and concerns_connection(packet.status):
            raise error_for(packet.command, packet.status, "set")
        if isinstance(packet, protocol.StatusChange):
            self._changes.add(packet.event)
        return packet


def _is_at_leisure(packet: protocol.FromServer) -> bool:
    """Whether a tracker that was asked for its status has told it, and is not busy."""
    return isinstance(packet, protocol.Answer) and packet.status == protocol.ResultStatus.ALL_OK


def _is_about(packet: protocol.FromServer, command: int) -> bool:
    return isinstance(packet, protocol.Answer | protocol.ErrorReport) and packet.command == command
