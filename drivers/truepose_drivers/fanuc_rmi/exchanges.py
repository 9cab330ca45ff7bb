"""One exchange at a time with a controller, and what it says unasked."""

import asyncio
from typing import Final

from truepose_drivers.errors import (
    ConnectionLostError,
    DeviceRefusedError,
    NoReplyError,
    NotInitialisedError,
)
from truepose_drivers.fanuc_rmi.protocol.messages import Command, Session, command, decode_status
from truepose_drivers.fanuc_rmi.protocol.packets import (
    Kind,
    Packet,
    PacketReader,
    RmiProtocolError,
    encode,
)
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link

_STATUS: Final = command(Command.STATUS)


class Exchanges(Conversation[Packet]):
    """Questions to a controller and their replies; errors of refusals leave the connection as it is."""

    def __init__(self, link: Link, *, alive_s: float, answer_s: float) -> None:
        super().__init__(link, PacketReader, harmless=(DeviceRefusedError,))
        self._alive_s = alive_s  # of silence during a motion, after which the controller is asked
        self._answer_s = answer_s  # which that may take
        self.holds = True  # no motion is taken before the controller was initialised, again after a fault

    async def reply_to(self, request: Packet, timeout_s: float) -> Packet:
        """Send a request and return its reply."""
        await self._send(request, timeout_s)
        while not _answers(packet := await self.next(), request):
            self._note(packet)
        return packet

    async def end_of(self, instruction: Packet, timeout_s: float) -> Packet:
        """Send an instruction and return its reply, which comes when it has been carried out.

        Meanwhile the controller is asked for its status again and again, so that a dead one is noticed.
        """
        give_up_s = asyncio.get_running_loop().time() + timeout_s
        await self._send(instruction, self._alive_s)
        end: Packet | None = None
        stopped = ""
        asked = False
        while asked or (end is None and not stopped):
            packet = await self._heard(asked=asked)
            if packet is None:
                self._require_time(give_up_s)
                await self._link.send(encode(_STATUS))
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
            raise NotInitialisedError(f"the robot stopped on its way: {stopped}")
        return end

    async def _send(self, request: Packet, timeout_s: float) -> None:
        async for packet in self.arrived():
            self._note(packet)
        await self.send(
            encode(request),
            timeout_s=timeout_s,
            silence=f"the robot at {self.address} is connected and says nothing: look at the pendant, then"
            " connect again",
        )

    async def _heard(self, *, asked: bool) -> Packet | None:
        self.expect(self._answer_s if asked else self._alive_s, self._silence)
        try:
            return await self.next()
        except NoReplyError:
            if asked:
                raise
            return None

    def _require_time(self, give_up_s: float) -> None:
        if asyncio.get_running_loop().time() > give_up_s:
            raise NoReplyError(
                f"the robot at {self.address} does not report the end of its motion: look at the pendant for"
                " a program on hold, then connect again"
            )

    def _note(self, packet: Packet) -> str:
        """Take what comes unasked, and return why nothing moves any more; raises RmiProtocolError."""
        match packet.kind, packet.name:
            case Kind.SESSION, Session.TERMINATE:
                raise ConnectionLostError(
                    "the robot ended the session, as it does after an hour of silence: connect again"
                )
            case Kind.SESSION, Session.SYSTEM_FAULT:
                self.holds = True
                return "a fault is shown on its pendant"
            case Kind.SESSION, Session.ASCII_READY:
                return ""
            case Kind.INSTRUCTION, _ if self.holds:
                return ""  # of a motion that a fault has ended
        raise RmiProtocolError(f"the robot said {packet.name}, which was not asked: connect again")


def _answers(packet: Packet, request: Packet) -> bool:
    named = (packet.kind, packet.name) == (request.kind, request.name)
    return named and (
        request.kind is not Kind.INSTRUCTION or packet.whole("SequenceID") == request.whole("SequenceID")
    )


def _why_stopped(answer: Packet) -> str:
    return "" if decode_status(answer).running else "its program was ended on the pendant"
