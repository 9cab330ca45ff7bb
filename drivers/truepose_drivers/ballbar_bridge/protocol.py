"""Lines of a ballbar bridge: one JSON object a line, UTF-8, from the bridge to us. See README.md.

``{"model": "QC20-W", "serial": "12A345", "resolution_mm": 0.0001}`` may come once, first; then a line for
each value, ``{"deviation_mm": 0.1234, "signal": "good", "temperature_c": 20.1, "sequence": 17}``. Only
`deviation_mm` is required, a number, or null without a signal. Keys not listed here are ignored.
"""

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias, cast, get_args

from truepose_drivers.framing import JsonLineError, decode_object, encode_object, finite_number

Signal: TypeAlias = Literal["good", "out_of_range", "none"]
_SIGNALS = get_args(Signal)
FINEST_MM = 1e-4  # of a QC20-W: what a bridge that does not say has
_UNIT = "mm"
_HIGHEST_SEQUENCE = 2**63 - 1
_FURTHEST_MM = 1000.0  # no ballbar travels as far: whoever sends more sends another unit


class BridgeProtocolError(JsonLineError):
    """A line that is none of a ballbar bridge."""


@dataclass(frozen=True, slots=True)
class Hello:
    """What the bridge says of the ballbar."""

    model: str = ""
    serial: str = ""
    resolution_mm: float = FINEST_MM
    range_mm: float = _FURTHEST_MM  # either way of zero; no value lies beyond its stop


@dataclass(frozen=True, slots=True)
class BridgeReading:
    """One value of the ballbar."""

    deviation_mm: float  # NaN without a signal
    signal: Signal
    temperature_c: float | None = None
    sequence: int | None = None


Message: TypeAlias = Hello | BridgeReading


def encode(message: Message) -> bytes:
    """Return the line of a message."""
    match message:
        case Hello(model, serial, resolution_mm, range_mm):
            return encode_object({
                "model": model,
                "serial": serial,
                "unit": _UNIT,
                "resolution_mm": resolution_mm,
                "range_mm": range_mm,
            })
        case BridgeReading(deviation_mm, signal, temperature_c, sequence):
            return encode_object({
                "deviation_mm": None if math.isnan(deviation_mm) else deviation_mm,
                "signal": signal,
                "temperature_c": temperature_c,
                "sequence": sequence,
            })


def decode(line: bytes) -> Message:
    """Read a line; raises JsonLineError with a sentence for whoever writes the bridge."""
    document = decode_object(line)
    # In every line, and before all else: a small value in inches would pass every other check.
    if document.get("unit", _UNIT) != _UNIT:
        raise BridgeProtocolError(f"unit is {str(document['unit'])[:40]!r}: values are sent in millimetres")
    if "deviation_mm" in document:
        return _reading(document)
    if document.keys() & {"model", "serial", "resolution_mm", "range_mm", "unit"}:
        return _hello(document)
    raise BridgeProtocolError(f"{line[:80]!r} has no deviation_mm: every value needs one")


def _reading(document: dict[str, object]) -> BridgeReading:
    shown = document["deviation_mm"]
    deviation_mm = math.nan if shown is None else _number(shown, "deviation_mm")
    if abs(deviation_mm) > _FURTHEST_MM:
        raise BridgeProtocolError(f"deviation_mm is {shown!r}: expected a deviation in millimetres")
    signal = document.get("signal", "none" if shown is None else "good")
    if signal not in _SIGNALS:
        raise BridgeProtocolError(f"signal is {signal!r}; expected one of {', '.join(_SIGNALS)}")
    if shown is None and signal != "none":
        raise BridgeProtocolError(f"signal is {signal} and deviation_mm is null: a signal has a value")
    temperature, sequence = document.get("temperature_c"), document.get("sequence")
    if sequence is not None and (isinstance(sequence, bool) or not isinstance(sequence, int)):
        raise BridgeProtocolError(f"sequence is {sequence!r}; expected a whole number")
    if sequence is not None and abs(sequence) > _HIGHEST_SEQUENCE:
        raise BridgeProtocolError(f"sequence is {sequence:.3g}; expected a count of values")
    return BridgeReading(
        # A number that comes without a signal is no measurement, whatever it is.
        math.nan if signal == "none" else deviation_mm,
        cast(Signal, signal),
        None if temperature is None else _number(temperature, "temperature_c"),
        sequence,
    )


def _hello(document: dict[str, object]) -> Hello:
    resolution_mm = _number(document.get("resolution_mm", FINEST_MM), "resolution_mm")
    range_mm = _number(document.get("range_mm", _FURTHEST_MM), "range_mm")
    for name, value in (("resolution_mm", resolution_mm), ("range_mm", range_mm)):
        if not 0.0 < value <= _FURTHEST_MM:
            raise BridgeProtocolError(
                f"{name} is {value:g}: expected a positive number, {_FURTHEST_MM:g} mm at most"
            )
    return Hello(_text(document, "model"), _text(document, "serial"), resolution_mm, range_mm)


def _text(document: dict[str, object], key: str) -> str:
    value = document.get(key, "")
    if not isinstance(value, str):
        raise BridgeProtocolError(f"{key} is {str(value)[:40]!r}; expected a text")
    return value


def _number(value: object, key: str) -> float:
    number = finite_number(value)
    if number is None:
        raise BridgeProtocolError(f"{key} is {str(value)[:40]!r}; expected a number")
    return number
