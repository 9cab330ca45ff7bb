"""RTDE: what one client asked to read and to write, and the stream between start and pause."""

import asyncio
import contextlib
import math
from collections.abc import Mapping

from truepose_drivers.universal_robots.protocol.errors import UrProtocolError
from truepose_drivers.universal_robots.protocol.packets import (
    PROTOCOL_VERSION,
    Kind,
    Packet,
    PacketReader,
    controller_version,
    encode,
    recipe_reply,
    requested_outputs,
    requested_version,
    text_message,
    verdict,
    words,
)
from truepose_drivers.universal_robots.protocol.recipes import IN_USE, NOT_FOUND, Recipe
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.universal_robots.controller import (
    READABLE,
    SOFTWARE,
    WRITABLE,
    Controller,
)

_CHUNK_BYTES = 4096
_FASTEST_HZ = 125.0  # of the CB series
_OUTPUTS_NUMBER = 1
_FIRST_INPUTS_NUMBER = 1
_MOST_RECIPES = 255
_EXCEPTION = 0  # level of a text


class RtdeClient:
    """One client of RTDE."""

    def __init__(self, controller: Controller, writer: asyncio.StreamWriter) -> None:
        self._controller = controller
        self._writer = writer
        self._outputs: Recipe | None = None
        self._inputs: dict[int, Recipe] = {}
        self._period_s = 1.0 / _FASTEST_HZ
        self._streaming: asyncio.Task[None] | None = None

    def tell(self, message: str) -> None:
        """Pass on what the controller says to people."""
        self._writer.write(encode(text_message(message, "truepose simulator", _EXCEPTION)))

    def answer(self, packet: Packet) -> Packet | None:
        """Do what a packet asks and return the reply; data and texts have none."""
        match packet.kind:
            case Kind.VERSION:
                accepted = requested_version(packet.payload) == PROTOCOL_VERSION
                return verdict(Kind.VERSION, accepted=accepted)
            case Kind.CONTROLLER:
                return controller_version(SOFTWARE)
            case Kind.OUTPUTS:
                return self._set_outputs(packet.payload)
            case Kind.INPUTS:
                return self._set_inputs(words(packet.payload))
            case Kind.START | Kind.PAUSE:
                return verdict(packet.kind, accepted=self._switch(on=packet.kind is Kind.START))
            case Kind.DATA:
                self._take(packet.payload)
        return None

    def leave(self) -> None:
        """Stop streaming and free the inputs."""
        self._switch(on=False)
        for recipe in self._inputs.values():
            self._controller.written_by_others.difference_update(recipe.fields)

    def _set_outputs(self, payload: bytes) -> Packet:
        frequency_hz, names = requested_outputs(payload)
        if not (math.isfinite(frequency_hz) and frequency_hz > 0.0):
            raise UrProtocolError(f"{frequency_hz} Hz is no frequency")
        self._period_s = 1.0 / min(frequency_hz, _FASTEST_HZ)
        types = _types(names, READABLE)
        known = NOT_FOUND not in types
        self._outputs = Recipe(_OUTPUTS_NUMBER, dict(zip(names, types, strict=True))) if known else None
        return recipe_reply(Kind.OUTPUTS, _OUTPUTS_NUMBER if known else 0, types)

    def _set_inputs(self, names: list[str]) -> Packet:
        taken = self._controller.written_by_others
        types = [
            IN_USE if name in taken else kind
            for name, kind in zip(names, _types(names, WRITABLE), strict=True)
        ]
        number = len(self._inputs) + _FIRST_INPUTS_NUMBER
        if {IN_USE, NOT_FOUND} & set(types) or number > _MOST_RECIPES:
            return recipe_reply(Kind.INPUTS, 0, types)
        self._inputs[number] = Recipe(number, dict(zip(names, types, strict=True)))
        taken.update(names)
        return recipe_reply(Kind.INPUTS, number, types)

    def _take(self, payload: bytes) -> None:
        recipe = self._inputs.get(payload[0] if payload else 0)
        if recipe is None:
            raise UrProtocolError("data for a recipe that was not agreed on")
        self._controller.registers.update(recipe.unpack(payload))

    def _switch(self, *, on: bool) -> bool:
        if self._streaming is not None:
            self._streaming.cancel()
            self._streaming = None
        if on and self._outputs is not None:
            self._streaming = asyncio.create_task(self._stream(self._outputs))
        return self._outputs is not None or not on

    async def _stream(self, recipe: Recipe) -> None:
        # A stream cannot run in cell time that stands still: its period is wall time.
        while not self._writer.is_closing():
            await asyncio.sleep(self._period_s)
            values = {name: self._controller.value(name) for name in recipe.fields}
            self._writer.write(encode(recipe.pack(values)))


def rtde_endpoint(controller: Controller) -> Endpoint:
    """Build RTDE of a controller."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        client = RtdeClient(controller, writer)
        controller.listeners.append(client.tell)
        try:
            with contextlib.suppress(UrProtocolError):  # the controller hangs up
                await _converse(client, reader, writer)
        finally:
            controller.listeners.remove(client.tell)
            client.leave()

    return Endpoint("robot", "ur_rtde", serve)


async def _converse(client: RtdeClient, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    packets = PacketReader()
    while data := await reader.read(_CHUNK_BYTES):
        packets.receive_data(data)
        while (packet := packets.next_message()) is not None:
            reply = client.answer(packet)
            if reply is not None:
                writer.write(encode(reply))
        await writer.drain()


def _types(names: list[str], known: Mapping[str, str]) -> list[str]:
    return [known.get(name, NOT_FOUND) for name in names]
