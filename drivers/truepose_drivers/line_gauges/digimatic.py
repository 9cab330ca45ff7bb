"""The data line of Mitutoyo's input tools and multiplexers: ``01A+0000.123``.

Source: Mitutoyo's manual 99MAF600B and the public clients pytuyo and mitutoyo_reader: 0, channel, A, sign,
and a number of eight or nine characters.
"""

import re
from typing import Final

from truepose_drivers.line_gauges.value_form import Value, read_value, write_value

_VALUE: Final = re.compile(r"0(\d)A([+-](?=[\d.]{8,9}$)\d+\.?\d*)")
_ERROR: Final = re.compile(r"(9\d\d)")

NOT_CONNECTED: Final = 911  # no gauge on the cable, or it is off and says nothing
NOT_CONVERTIBLE: Final = 912  # the gauge sent something that is no value


def data_line(channel: int, value: Value, width: int) -> str:
    """Return the line of a value."""
    return f"0{channel}A{write_value(value, width)}"


def read_data_line(line: str) -> tuple[int, Value] | None:
    """Return channel and value of a line, None for one that is no data line."""
    match = _VALUE.fullmatch(line)
    return None if match is None else (int(match[1]), read_value(match[2]))


def read_error_line(line: str) -> int | None:
    """Return the number of an error line, None for one that is none."""
    match = _ERROR.fullmatch(line)
    return None if match is None else int(match[1])
