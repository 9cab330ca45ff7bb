"""The person at a simulated cell, over TCP: what demonstrations and tests have it do."""

from truepose_drivers.api import Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.cell_hands.protocol import Answer, Do, Request, Who, decode_answer, encode
from truepose_drivers.errors import DeviceRefusedError
from truepose_drivers.framing import LineReader, Refusal
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, OnePortDevice, introduction
from truepose_drivers.transports.tcp import tcp_link

_ANSWER_TIMEOUT_S = 30.0  # wall time; at real pace the hands take as long as a person's


class CellHands(OnePortDevice):
    """The hands of a simulated cell on a link."""

    def __init__(self, link: Link, *, answer_timeout_s: float = _ANSWER_TIMEOUT_S) -> None:
        self._conversation = Conversation(link, LineReader)
        super().__init__(self._conversation)
        self._answer_timeout_s = answer_timeout_s

    async def connect(self) -> None:
        """Open the link and ask who is there; raises ConnectFailedError."""
        await self._conversation.open()
        async with introduction(self._conversation):
            await self._ask(Who())

    async def identify(self) -> DeviceIdentity:
        """Ask who is there."""
        match await self._ask(Who()):
            case Refusal(sentence):
                raise DeviceRefusedError(sentence)
            case done:
                return DeviceIdentity("truepose", done.who or "simulated hands", "none", "1")

    async def do(self, action: str, details: Options) -> None:
        """Do one thing, e.g. `connect` with `base` and `tool`; raises DeviceRefusedError."""
        match await self._ask(Do(action, details)):
            case Refusal(sentence):
                raise DeviceRefusedError(sentence)

    async def _ask(self, request: Request) -> Answer:
        try:
            line = encode(request)
        except ValueError as error:
            raise DeviceRefusedError(f"the hands cannot do that: {error}") from error
        silence = (
            f"the simulated hands at {self._conversation.address} did not"
            f" respond within {self._answer_timeout_s:g} s: check that the simulated cell runs"
        )
        return await self._conversation.ask(
            line, decode_answer, timeout_s=self._answer_timeout_s, silence=silence
        )


def _open(options: Options, clock: Clock) -> CellHands:
    return CellHands(tcp_link(options))


_OPTIONS = {
    "host": "address of the simulated cell",
    "port": "TCP port of its hands",
}
PLUGIN = DriverPlugin("cell_hands", "hands", "hands", _OPTIONS, _open)
