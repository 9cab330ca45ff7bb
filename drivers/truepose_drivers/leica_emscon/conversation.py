"""The conversation with an emScon server: one request at a time, its answer among whatever else arrives.

A refusal or a failed measurement is an answer; whatever else breaks an exchange off closes the link.
"""

from truepose_drivers.errors import DeviceRefusedError, MeasurementFailedError
from truepose_drivers.leica_emscon.protocol import (
    Answer,
    Command,
    ErrorReport,
    Frame,
    FrameReader,
    FromServer,
    PacketError,
    PacketType,
    Record,
    Request,
    Result,
    ResultStatus,
    StatusChange,
    decode_from_server,
    encode,
)
from truepose_drivers.leica_emscon.sentences import Purpose, command_name, concerns_connection, error_for
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link

_STATIONARY_RESULTS = frozenset({PacketType.SINGLE_MEAS_RESULT, PacketType.SINGLE_MEAS_RESULT_2})
_MOST_ITEMS = 1_000  # of a list; a tracker stores a few dozen reflectors


class TrackerConversation:
    """Requests and answers on one link; unasked packets in between are digested."""

    def __init__(self, link: Link) -> None:
        self._frames: Conversation[Frame] = Conversation(
            link, FrameReader, harmless=(DeviceRefusedError, MeasurementFailedError)
        )
        self._changes: set[int] = set()

    @property
    def is_open(self) -> bool:
        """Whether the link is up as far as known."""
        return self._frames.is_open

    async def open(self) -> None:
        """Open the link afresh; raises ConnectFailedError."""
        self._changes = set()
        await self._frames.open()

    async def close(self) -> None:
        """Close the link; never raises."""
        await self._frames.close()

    async def ask(self, request: Request, *, timeout_s: float, purpose: Purpose = "set") -> Record:
        """Return the members of the answer; raises the error that its status means."""
        async with self._frames.turn():
            await self._send(request, timeout_s)
            values = await self._answer(request.command, purpose)
            await self._digest_pending(after_answer=True)
            return values

    async def ask_list(self, command: Command, *, timeout_s: float) -> list[Record]:
        """Return the items of a list command, which come one a packet; may be empty."""
        async with self._frames.turn():
            await self._send(Request(command), timeout_s)
            items = [await self._answer(command, "set")]
            total = items[0].integer(next(iter(items[0])))  # every item carries the total first
            if not 0 <= total <= _MOST_ITEMS:
                raise PacketError(f"the tracker announces {total} items for {command_name(command)}")
            while len(items) < total:
                items.append(await self._answer(command, "set"))
            return items[:total]

    async def measure(self, *, timeout_s: float) -> Result:
        """Start a stationary measurement and return its result, of either statistic mode.

        A result that arrives before the answer was under way before we asked: it is not ours.
        """
        command = Command.START_MEASUREMENT
        async with self._frames.turn():
            await self._send(Request(command), timeout_s)
            accepted = False
            while True:
                match await self._next_packet():
                    case Answer(answered, status) if answered == command:
                        if status != ResultStatus.ALL_OK:
                            raise error_for(command, status, "measure")
                        accepted = True
                    case ErrorReport(_, status):  # nothing else is active that it could be about
                        raise error_for(command, status, "measure")
                    case Result(kind, _, status) as result if accepted and kind in _STATIONARY_RESULTS:
                        if status != ResultStatus.ALL_OK:
                            raise error_for(command, status, "measure")
                        await self._digest_pending(after_answer=True)
                        return result

    def take_changes(self) -> frozenset[int]:
        """Return what the tracker has announced since this was asked last (SystemStatusChange)."""
        changes, self._changes = frozenset(self._changes), set()
        return changes

    async def _send(self, request: Request, timeout_s: float) -> None:
        """Send a request whose answers are awaited from now on."""
        await self._digest_pending()
        silence = (
            f"the tracker at {self._frames.address} did not answer {command_name(request.command)} in time:"
            " look whether it is still running, then connect again"
        )
        await self._frames.send(encode(request), timeout_s=timeout_s, silence=silence)

    async def _digest_pending(self, *, after_answer: bool = False) -> None:
        """Read what arrived unasked, so that it is not taken for news.

        Right after an answer nothing may stand there that answers: nobody knows which of them is ours.
        """
        async for frame in self._frames.arrived():
            packet = self._take(frame)
            if after_answer and isinstance(packet, Answer | Result) and _answers(packet):
                raise PacketError(
                    f"the tracker at {self._frames.address} answered more than was asked: connect again"
                )

    async def _answer(self, command: int, purpose: Purpose) -> Record:
        while True:
            match await self._next_packet():
                case Answer(answered, status, values) if answered == command:
                    if status != ResultStatus.ALL_OK:
                        raise error_for(command, status, purpose)
                    return values
                case ErrorReport(active, status) if active == command:
                    raise error_for(command, status, purpose)

    async def _next_packet(self) -> FromServer:
        return self._take(await self._frames.next())

    def _take(self, frame: Frame) -> FromServer:
        packet = decode_from_server(frame)
        if isinstance(packet, ErrorReport) and concerns_connection(packet.status):
            raise error_for(packet.command, packet.status, "set")
        if isinstance(packet, StatusChange):
            self._changes.add(packet.event)
        return packet


def _answers(packet: Answer | Result) -> bool:
    return isinstance(packet, Answer) or packet.packet_type in _STATIONARY_RESULTS
