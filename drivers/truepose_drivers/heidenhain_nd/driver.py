"""A length gauge behind a Heidenhain ND 28x counter, on a serial port or a terminal server."""

import math
from dataclasses import dataclass, replace

from truepose_drivers.api import BallbarReading, Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.errors import NoReplyError
from truepose_drivers.heidenhain_nd import protocol
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, OnePortDevice, introduction
from truepose_drivers.transports.serial import SERIAL_OPTIONS, Framing, baud, serial_or_tcp

_REPLY_TIMEOUT_S = 1.0  # on top of the time on the line; a counter takes 50 ms at most
# Eleven bits a character at 7E2: start, seven of data, parity, two stops.
_ON_THE_LINE_BITS = 90 * 11  # of three commands and their answers
_MOST_REFUSALS = 3
_IDENTITY_LINES = 3
# Factory setting of the counters; the manual lets the operator choose the rate alone.
_FACTORY = Framing(baud=9600, data_bits=7, parity="E", stop_bits=2, xon_xoff=True)
_RATES = (110, 150, 300, 600, 1200, 2400, 4800, 9600, 19_200, 38_400, 57_600, 115_200)
_CHECK_LINE = "check cable, power, and the counter's baud rate"


@dataclass(frozen=True, slots=True)
class _Answers:
    """What came back on error text, value and lamps asked in one go."""

    value: protocol.Line | None = None
    lamps: protocol.Line | None = None
    error_text: str | None = None
    refusals: int = 0


class HeidenhainCounter(OnePortDevice):
    """An ND 28x on a link. Keeps the conversation; computes nothing."""

    def __init__(self, link: Link, clock: Clock, *, reply_timeout_s: float = _REPLY_TIMEOUT_S) -> None:
        self._conversation: Conversation[protocol.Reply] = Conversation(link, protocol.ReplyReader)
        super().__init__(self._conversation)
        self._counter = f"the counter at {link.address}"
        self._clock = clock
        self._reply_timeout_s = reply_timeout_s
        self._inch = False  # what the counter displayed when it was asked last

    async def connect(self) -> None:
        """Open the link, ask who is there and which unit is displayed; raises ConnectFailedError."""
        await self._conversation.open()
        async with introduction(self._conversation), self._conversation.turn():
            await self._ask_identity()
            _, lamps = await self._ask_state()
        self._inch = lamps.inch

    async def identify(self) -> DeviceIdentity:
        """Ask for model and software number; the counter knows no serial number of its gauge."""
        async with self._conversation.turn():
            lines = await self._ask_identity()
        model, software, _ = protocol.decode_identity(lines)
        return DeviceIdentity("HEIDENHAIN", model or "unknown", "unknown", software or "unknown")

    async def read(self) -> BallbarReading:
        """Return what the counter displays now; no signal where it displays an error instead."""
        async with self._conversation.turn():
            answers, lamps = await self._ask_state()
            if lamps.inch != self._inch:  # the key was pressed since: perhaps between value and indicators
                self._inch = lamps.inch
                answers, lamps = await self._ask_state()
            if lamps.inch != self._inch:
                raise protocol.NdProtocolError(
                    f"the unit displayed at {self._counter} keeps changing: do not"
                    " press its keys during a reading"
                )
        time_s = await self._clock.now_s()
        resolution_mm = protocol.to_mm(1, lamps)
        # What A0200 answers while an error is displayed is not in the manual: the error decides. A counter
        # that always answers leaves it blank where there is none.
        if answers.value is None or answers.error_text:
            return BallbarReading(math.nan, "none", resolution_mm, time_s)
        deviation_mm = protocol.to_mm(protocol.decode_count(answers.value), lamps)
        # The counter does not know the range of the gauge; the limits of its sorting mode are set to it.
        sorted_out = lamps.below or lamps.above
        return BallbarReading(deviation_mm, "out_of_range" if sorted_out else "good", resolution_mm, time_s)

    async def _ask_identity(self) -> list[protocol.Line]:
        """Ask for the identity, which has a form of its own: replies to what was asked before end here."""
        await self._send(protocol.IDENTITY)
        lines: list[protocol.Line] = []
        refused = False
        while len(lines) < _IDENTITY_LINES:
            try:
                reply = await self._conversation.next()
            except NoReplyError as error:
                if not refused:
                    raise
                raise protocol.NdProtocolError(
                    f"{self._counter} refuses to identify itself (A0000)"
                ) from error
            refused |= isinstance(reply, protocol.Refusal)
            if isinstance(reply, protocol.Line) and protocol.is_identity_line(reply, len(lines)):
                lines.append(reply)
            else:
                lines = (
                    [reply]
                    if isinstance(reply, protocol.Line) and protocol.is_identity_line(reply, 0)
                    else []
                )
        return lines

    async def _ask_state(self) -> tuple[_Answers, protocol.Lamps]:
        """Ask for error text, value and lamps at once, which the counter's buffer holds easily.

        Whether a counter without an error refuses A0301 or ignores it is not in the manual; the lamps come
        last and answer always, so that either does.
        """
        await self._send(protocol.ERROR_TEXT, protocol.VALUE, protocol.LAMPS)
        answers = _Answers()
        while (lamps := answers.lamps) is None:
            answers = _with(answers, await self._conversation.next())
            if answers.refusals == _MOST_REFUSALS - (answers.value is not None):
                raise protocol.NdProtocolError(
                    f"{self._counter} does not report its status indicators (A0800):"
                    " it is not an ND 2xx B or ND 287"
                )
        await self._require_end()
        return answers, protocol.decode_lamps(lamps)

    async def _require_end(self) -> None:
        """See that nothing but prints stands behind the last answer; raises NdProtocolError."""
        async for reply in self._conversation.arrived():
            if not isinstance(reply, protocol.Line) or reply.opened:
                raise protocol.NdProtocolError(
                    f"{self._counter} sent more data than requested:"
                    " one of the answers is a late reply, and it is unknown which"
                )

    async def _send(self, *commands: protocol.Command) -> None:
        """Drop what was printed at the counter's keys, then ask."""
        await self._conversation.drain()
        await self._conversation.send(
            b"".join(map(protocol.encode_request, commands)),
            timeout_s=self._reply_timeout_s,
            silence=f"{self._counter} did not respond within {self._reply_timeout_s:.1f} s: {_CHECK_LINE}",
        )


def _with(answers: _Answers, reply: protocol.Reply) -> _Answers:
    """Return the answers with one more; raises NdProtocolError where it stands in a wrong place."""
    if isinstance(reply, protocol.Refusal):
        return replace(answers, refusals=answers.refusals + 1)
    if not isinstance(reply, protocol.Line):
        raise protocol.NdProtocolError("the counter acknowledged a command that was not sent: connect again")
    if not reply.opened:
        return answers  # an operator pressed PRINT meanwhile
    kind = protocol.reply_kind(reply)
    # Error, value, lamps is the order of the questions: behind the value only the lamps can be of this turn.
    if answers.value is not None and kind != "lamps":
        raise protocol.NdProtocolError(
            f"{reply.text!r} matches no request: it is a late reply to an earlier one"
        )
    match kind:
        case "value":
            return replace(answers, value=reply)
        case "lamps":
            return replace(answers, lamps=reply)
        case "text" if answers.error_text is None:
            return replace(answers, error_text=reply.text.strip())
    raise protocol.NdProtocolError(
        "the counter reported its error twice: one is a late reply to an earlier request"
    )


def _open(options: Options, clock: Clock) -> HeidenhainCounter:
    link = serial_or_tcp(options, _FACTORY, rates=_RATES, what="counter")
    # At 110 baud the characters alone are on the line for 8 s, which must not pass for silence.
    on_the_line_s = _ON_THE_LINE_BITS / baud(options, _FACTORY, _RATES) if "serial" in options else 0.0
    return HeidenhainCounter(link, clock, reply_timeout_s=_REPLY_TIMEOUT_S + on_the_line_s)


_OPTIONS = {**SERIAL_OPTIONS, "baud": f"rate set at the counter, default {_FACTORY.baud}; always 7E2"}
PLUGIN = DriverPlugin("heidenhain_nd", "ballbar", "nd28x", _OPTIONS, _open, also=("linear_gauge",))
