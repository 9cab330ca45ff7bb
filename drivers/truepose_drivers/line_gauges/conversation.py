"""Options and conversation of gauges that answer a line; a dialect says what is asked and answered."""

import math
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Generic, Protocol, TypeAlias, TypeVar

from truepose_drivers import options as option
from truepose_drivers.api import BallbarReading, Clock, DeviceIdentity, Options
from truepose_drivers.errors import ConfigurationError, DeviceRefusedError
from truepose_drivers.line_gauges.protocol import (
    MOST_DECIMALS,
    MOST_LESSONS,
    LineGaugeError,
    Value,
    ValueForm,
)
from truepose_drivers.transports.conversation import Conversation, Reader
from truepose_drivers.transports.link import Link, OnePortDevice, drain, introduction
from truepose_drivers.transports.serial import Framing, serial_or_tcp


@dataclass(frozen=True, slots=True)
class GaugeSettings:
    """What the cell file says of the gauges behind a box."""

    channels: tuple[int, ...] = (1,)
    range_mm: float = math.inf  # either way of zero; what lies beyond is out of range
    reversed: bool = False  # the box counts up as the plunger comes out
    decimals: int | None = None  # behind the point in millimetres; None: learnt from the first values


def gauge_settings(options: Options, *, most_channels: int) -> GaugeSettings:
    """Read the options that all of them have; raises ConfigurationError."""
    return GaugeSettings(
        _channels(options, most_channels),
        option.positive(options, "range_mm", 1.0) if "range_mm" in options else math.inf,
        _reversed(options),
        decimals(options),
    )


def decimals(options: Options) -> int | None:
    """Read how many digits stand behind the point; raises ConfigurationError."""
    number = options.get("decimals")
    if number is None:
        return None
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number <= MOST_DECIMALS:
        raise ConfigurationError(f"option decimals is {number!r}: give a number from 0 to {MOST_DECIMALS}")
    return number


def _channels(options: Options, most: int) -> tuple[int, ...]:
    words = option.text(options, "channels") or "1"
    channels = tuple(int(word) if word.isdecimal() else 0 for word in words.split())
    if not all(1 <= channel <= most for channel in channels) or len(set(channels)) < len(channels):
        raise ConfigurationError(
            f"option channels is {words!r}: give different numbers from 1 to {most}, such as 1 2 3"
        )
    return channels


def _reversed(options: Options) -> bool:
    value = options.get("reversed", False)
    if not isinstance(value, bool):
        raise ConfigurationError(f"option reversed is {value!r}: give true or false")
    return value


SHARED_OPTIONS: Final[Mapping[str, str]] = {
    "channels": "channels in use, one gauge each, such as 1 2 3; default 1",
    "range_mm": "range to either side of zero; values beyond it are out of range; default: as the box"
    " reports",
    "reversed": "true if the value rises as the plunger extends; default false",
    "decimals": "decimal places in millimetres; default: taken from the first values",
}
_REPLY_TIMEOUT_S: Final = 1.0  # a Digimatic gauge takes up to a quarter of a second to send its value
_SETTLE_S: Final = 0.3  # a Digimatic gauge needs no longer, and the line no time
_MOST_TRIES: Final = 3  # of a question that somebody's press of a key disturbed

Message = TypeVar("Message")


@dataclass(frozen=True, slots=True)
class Display:
    """What one gauge says."""

    value: Value | None  # None where it has none
    sorted_out: bool = False  # beyond the limits that were set at the box itself


Ask: TypeAlias = Callable[[bytes], Awaitable[Message]]


class Dialect(Protocol[Message]):
    """What a maker's box understands."""

    @property
    def box(self) -> str:
        """What stands at the other end, for error texts."""
        ...

    def new_reader(self) -> Reader[Message]:
        """Return a reader of its lines."""
        ...

    async def identity(self, ask: Ask[Message], channels: Sequence[int]) -> DeviceIdentity:
        """Ask who is there."""
        ...

    async def displays(self, ask: Ask[Message], channels: Sequence[int]) -> Sequence[Display]:
        """Ask what the gauges show, in the order of `channels`."""
        ...


class LineGauges(OnePortDevice, Generic[Message]):
    """Gauges behind one box on a link; each channel that the cell file names is one gauge."""

    def __init__(
        self,
        link: Link,
        clock: Clock,
        dialect: Dialect[Message],
        settings: GaugeSettings,
        *,
        reply_timeout_s: float = _REPLY_TIMEOUT_S,
        settle_s: float = _SETTLE_S,
    ) -> None:
        """Prepare; an answer to a question of before comes within `settle_s` of connecting again."""
        self._link = link
        self._clock = clock
        self._dialect = dialect
        self._settings = settings
        self._reply_timeout_s = reply_timeout_s
        self._settle_s = settle_s
        # Kept over connections, as the gauges are.
        self._forms = [ValueForm(settings.decimals, LineGaugeError) for _ in settings.channels]
        self._has_asked = False  # so that an answer may still come after connecting again
        self._conversation: Conversation[Message] = Conversation(
            link, dialect.new_reader, harmless=(DeviceRefusedError,)
        )
        super().__init__(self._conversation)

    async def connect(self) -> None:
        """Open the link, let answers of before pass, and ask who is there; raises ConnectFailedError."""
        await self._conversation.open()
        async with introduction(self._conversation), self._conversation.turn():
            await drain(self._link, quiet_s=self._settle_s if self._has_asked else 0.0)
            await self._dialect.identity(self._ask, self._settings.channels)

    async def identify(self) -> DeviceIdentity:
        """Ask the box who it is; the gauges on it do not tell."""
        async with self._conversation.turn():
            return await self._dialect.identity(self._ask, self._settings.channels)

    async def read(self) -> BallbarReading:
        """Return what the first gauge shows now."""
        return (await self.read_channels())[0]

    async def read_channels(self) -> tuple[BallbarReading, ...]:
        """Return what all gauges show now, in the order of the cell file's channels."""
        async with self._conversation.turn():
            shown = await self._displays_in_form()
        time_s = await self._clock.now_s()
        return tuple(self._reading(one, form, time_s) for one, form in zip(shown, self._forms, strict=True))

    def _reading(self, shown: Display, form: ValueForm, time_s: float) -> BallbarReading:
        resolution_mm = form.resolution_mm
        if shown.value is None:
            return BallbarReading(math.nan, "none", resolution_mm, time_s)
        value_mm = -shown.value.shown if self._settings.reversed else shown.value.shown
        # Half a step more: the end of the range is within it, whatever a double makes of it.
        inside = not shown.sorted_out and abs(value_mm) <= self._settings.range_mm + 0.5 * resolution_mm
        return BallbarReading(value_mm, "good" if inside else "out_of_range", resolution_mm, time_s)

    async def _displays_in_form(self) -> Sequence[Display]:
        shown = await self._all_displays()
        # Two values in a row must agree on the form: one alone may be the one that lost a digit. Of those
        # read while learning only the last is returned.
        for _ in range(MOST_LESSONS):
            if all(form.known or one.value is None for form, one in zip(self._forms, shown, strict=True)):
                break
            before, shown = shown, await self._all_displays()
            for form, first, second in zip(self._forms, before, shown, strict=True):
                if first.value is not None and second.value is not None:
                    form.learn(first.value, second.value)
        for form, one in zip(self._forms, shown, strict=True):
            if one.value is not None:
                form.require(one.value)
        return shown

    async def _all_displays(self) -> Sequence[Display]:
        return await self._dialect.displays(self._ask, self._settings.channels)

    async def _ask(self, question: bytes) -> Message:
        """Ask, and return the answer; where a second line comes with it, nobody knows which it is."""
        box = f"{self._dialect.box} at {self._link.address}"
        self._has_asked = True
        silence = f"{box} does not respond: check cable, power and baud rate"
        for _ in range(_MOST_TRIES):
            await self._conversation.drain()
            await self._conversation.send(question, timeout_s=self._reply_timeout_s, silence=silence)
            message = await self._conversation.next()
            if await self._conversation.is_quiet():
                return message
        raise LineGaugeError(f"{box} sends data without a request: do not press keys on the gauge or the box")


def open_line_gauges(
    options: Options,
    clock: Clock,
    dialect: Dialect[Message],
    factory: Framing,
    *,
    most_channels: int,
    settle_s: float = _SETTLE_S,
) -> LineGauges[Message]:
    """Return the gauges of a cell file, whose box speaks `dialect`; raises ConfigurationError."""
    link = serial_or_tcp(options, factory, what="box")
    settings = gauge_settings(options, most_channels=most_channels)
    return LineGauges(link, clock, dialect, settings, settle_s=settle_s)
