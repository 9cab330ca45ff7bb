"""The two ports of the Remote Motion Interface: one names the other, where one client is served."""

import asyncio
import contextlib

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.fanuc_rmi import protocol
from truepose_drivers.framing import JsonLineError, LineReader
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.clients import one_client_endpoint, say_to_client
from truepose_simulators.instruments.robot.fanuc_rmi.controller import Controller
from truepose_simulators.instruments.robot.fanuc_rmi.program import RmiMove

_CHUNK_BYTES = 4096
_VERSION = {"MajorVersion": 9, "MinorVersion": 0}


def session_endpoint(controller: Controller, program: RmiMove) -> Endpoint:
    """Build the port where everything but the connecting is said."""

    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        program.tell = lambda packet: writer.write(protocol.encode(packet))
        try:
            with contextlib.suppress(JsonLineError):  # no end of line in sight: the controller hangs up
                await _serve(controller, program, reader, writer)
        finally:
            controller.lose_client()
            program.tell = lambda _: None

    return one_client_endpoint("robot-session", "rmi_session", attend, controller.cell)


def connect_endpoint(second: Endpoint) -> Endpoint:
    """Build the port where sessions begin."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        packets = protocol.PacketReader()
        with contextlib.suppress(RemoteProtocolError):  # the controller hangs up
            while data := await reader.read(_CHUNK_BYTES):
                packets.receive_data(data)
                while (packet := packets.next_message()) is not None:
                    writer.write(protocol.encode(_welcome(packet, second.port)))
                await writer.drain()

    return Endpoint("robot", "rmi", serve)


def _welcome(packet: protocol.Packet, port: int) -> protocol.Packet:
    # Clients of Stream Motion and of ROS 2 say so, and are answered alike.
    if packet.kind is not protocol.Kind.SESSION or not packet.name.startswith(protocol.Session.CONNECT):
        return protocol.Packet(protocol.Kind.COMMAND, "Unknown", {"ErrorID": protocol.UNKNOWN_COMMAND})
    return protocol.reply(packet, fields={"PortNumber": port or protocol.CONNECT_PORT + 1, **_VERSION})


def _packet(line: bytes) -> protocol.Packet:
    try:
        return protocol.decode(line)
    except RemoteProtocolError:
        return protocol.Packet(protocol.Kind.COMMAND, "Unknown")


async def _serve(
    controller: Controller, program: RmiMove, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
) -> None:
    """Answer until the client says that it goes, or is gone."""
    lines = LineReader()
    while data := await reader.read(_CHUNK_BYTES):
        lines.receive_data(data)
        while (line := lines.next_message()) is not None:
            packet = _packet(line)
            if packet.name == protocol.Session.DISCONNECT:
                controller.end()
                await say_to_client(controller.cell, writer, protocol.encode(protocol.reply(packet)))
                return
            if packet.kind is protocol.Kind.INSTRUCTION:
                program.take(packet)
                await writer.drain()
            else:
                await say_to_client(controller.cell, writer, protocol.encode(controller.answer(packet)))
