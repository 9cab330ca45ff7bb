"""A session with a controller: the port where it is asked for, and one exchange at a time at the other."""

import contextlib
from collections.abc import Callable
from typing import Final

from truepose_drivers.errors import (
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    LinkError,
    NoReplyError,
    NotInitialisedError,
)
from truepose_drivers.fanuc_rmi import protocol
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, now_s, open_patiently

_STATUS: Final = protocol.command(protocol.Command.STATUS)


class Exchanges(Conversation[protocol.Packet]):
    """Questions to a controller and their replies; errors of refusals leave the connection as it is."""

    def __init__(self, link: Link, *, alive_s: float, answer_s: float) -> None:
        super().__init__(link, protocol.PacketReader, harmless=(DeviceRefusedError,))
        self._alive_s = alive_s  # of silence during a motion, after which the controller is asked
        self._answer_s = answer_s  # which that may take
        self.holds = True  # no motion is taken before the controller was initialised, again after a fault

    async def reply_to(self, request: protocol.Packet, timeout_s: float) -> protocol.Packet:
        """Send a request and return its reply."""
        await self._send(request, timeout_s)
        while not _answers(packet := await self.next(), request):
            self._note(packet)
        return packet

    async def end_of(self, instruction: protocol.Packet, timeout_s: float) -> protocol.Packet:
        """Send an instruction and return its reply, which comes when it has been carried out.

        Meanwhile the controller is asked for its status again and again, so that a dead one is noticed.
        """
        give_up_s = now_s() + timeout_s
        await self._send(instruction, self._alive_s)
        end: protocol.Packet | None = None
        stopped = ""
        asked = False
        while asked or (end is None and not stopped):
            packet = await self._heard(asked=asked)
            if packet is None:
                self._require_time(give_up_s)
                await self._link.send(protocol.encode(_STATUS))
                asked = True
            elif asked and _answers(packet, _STATUS):
                asked = False
                stopped = stopped or _why_stopped(packet)
            elif end is None and _answers(packet, instruction):
                end = packet
            else:
                stopped = self._note(packet) or stopped
        if end is None:
            self.holds = True
            raise NotInitialisedError(f"the robot stopped during the motion: {stopped}")
        return end

    async def _send(self, request: protocol.Packet, timeout_s: float) -> None:
        async for packet in self.arrived():
            self._note(packet)
        await self.send(
            protocol.encode(request),
            timeout_s=timeout_s,
            silence=f"the robot at {self.address} is connected but does not respond: check the pendant, then"
            " connect again",
        )

    async def _heard(self, *, asked: bool) -> protocol.Packet | None:
        self.expect(self._answer_s if asked else self._alive_s, self._silence)
        try:
            return await self.next()
        except NoReplyError:
            if asked:
                raise
            return None

    def _require_time(self, give_up_s: float) -> None:
        if now_s() > give_up_s:
            raise NoReplyError(
                f"the robot at {self.address} did not report the end of its motion: check the pendant for"
                " a program on hold, then connect again"
            )

    def _note(self, packet: protocol.Packet) -> str:
        """Take what comes unasked, and return why nothing moves any more; raises RmiProtocolError."""
        match packet.kind, packet.name:
            case protocol.Kind.SESSION, protocol.Session.TERMINATE:
                raise ConnectionLostError(
                    "the robot ended the session, as it does after an hour of silence: connect again"
                )
            case protocol.Kind.SESSION, protocol.Session.SYSTEM_FAULT:
                self.holds = True
                return "a fault is shown on its pendant"
            case protocol.Kind.SESSION, protocol.Session.ASCII_READY:
                return ""
            case protocol.Kind.INSTRUCTION, _ if self.holds:
                return ""  # of a motion that a fault has ended
        raise protocol.RmiProtocolError(f"the robot sent {packet.name} without a request: connect again")


def _answers(packet: protocol.Packet, request: protocol.Packet) -> bool:
    named = (packet.kind, packet.name) == (request.kind, request.name)
    return named and (
        request.kind is not protocol.Kind.INSTRUCTION
        or packet.whole("SequenceID") == request.whole("SequenceID")
    )


def _why_stopped(answer: protocol.Packet) -> str:
    return "" if protocol.decode_status(answer).running else "its program was ended on the pendant"


_CONNECT: Final = protocol.session(protocol.Session.CONNECT)
_GOODBYE: Final = protocol.encode(protocol.session(protocol.Session.DISCONNECT))
_GOODBYE_S: Final = 0.3  # that its answer is waited for


class Handover:
    """A link that is opened at one port and goes on at another; whoever leaves it says so.

    The controller lets the next client in only some seconds after the last one: it is asked for so long.
    """

    def __init__(
        self, to_port: Callable[[int], Link], first_port: int, *, reply_s: float, patience_s: float
    ) -> None:
        self._to_port = to_port
        self._first = to_port(first_port)
        self._reply_s = reply_s
        self._patience_s = patience_s
        self._second: Link | None = None
        self.version = "RMI"  # of the interface, as it said when it was connected last

    @property
    def address(self) -> str:
        """Where the session began, for error texts."""
        return self._first.address

    @property
    def is_open(self) -> bool:
        """Whether the session is up as far as known."""
        return self._second is not None and self._second.is_open

    async def open(self) -> None:
        """Begin a session, dropping the one before; raises ConnectFailedError."""
        await self.close()
        await self._first.open()  # where nobody is, patience is of no use
        await open_patiently(
            self._go_on,
            within_s=self._patience_s,
            every_s=0.25,
            advice="also check that no other program is connected to the robot",
        )

    async def send(self, data: bytes) -> None:
        """Hand `data` to the session; raises ConnectionLostError."""
        await self._opened().send(data)

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return what has arrived, None after `timeout_s` of silence; raises ConnectionLostError."""
        return await self._opened().receive(timeout_s)

    async def close(self) -> None:
        """Say that the session ends, which has the controller stop what it was told to do; never raises."""
        second, self._second = self._second, None
        if second is not None:
            with contextlib.suppress(LinkError):
                # A session that ends without it leaves program RMI_MOVE holding the controller, which then
                # refuses the next FRC_Initialize (error 7015) until somebody deselects the program on the
                # pendant.
                await second.send(_GOODBYE)
                await second.receive(_GOODBYE_S)
            await second.close()

    async def _go_on(self) -> None:
        if not self._first.is_open:
            await self._first.open()
        # Asked anew at each try: some controllers name a port to a second client too, and let it wait there.
        port = await self._ask_for_port()
        second = self._to_port(port)
        await second.open()
        self._second = second

    async def _ask_for_port(self) -> int:
        try:
            port, self.version = await Conversation[protocol.Packet](self._first, protocol.PacketReader).ask(
                protocol.encode(_CONNECT),
                _named_port,
                timeout_s=self._reply_s,
                silence=f"no answer from {self.address}: is this the robot's address?",
            )
        finally:
            await self._first.close()
        return port

    def _opened(self) -> Link:
        if self._second is None:
            raise ConnectionLostError(f"not connected to {self.address}: connect first")
        return self._second


def _named_port(answer: protocol.Packet) -> tuple[int, str]:
    if (answer.kind, answer.name) != (_CONNECT.kind, _CONNECT.name):
        raise protocol.RmiProtocolError(f"the robot answers {answer.name} to {_CONNECT.name}")
    if (error := protocol.error_of(answer)) != 0:
        raise ConnectFailedError(f"the robot started no session: {protocol.in_words(error)}")
    return protocol.handed_over(answer)
