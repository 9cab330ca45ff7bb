"""Gauges as Keyence GT2 sensors behind a DL-EN1 unit: one question, and all of them answer."""

import math
from collections.abc import Sequence
from typing import Final

from truepose_drivers.keyence_gt2.protocol import (
    GO,
    HIGH,
    INVALID_COMMAND,
    LOW,
    STATES_AND_VALUES,
    VALUES,
    Amplifier,
    Amplifiers,
    Refused,
    encode,
)
from truepose_drivers.line_gauges.value_form import Value
from truepose_simulators.instruments.ballbars.length_source import Electronics
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.gauges.text_box import TextBox, box_endpoint, in_inches

_DECIMALS: Final = 4
_DECIMALS_OF_INCHES: Final = 5
_COMMAND_CHARACTERS: Final = 2


def keyence_gt2_endpoint(gauges: Sequence[Electronics], device: str = "gauge") -> Endpoint:
    """Build the endpoint of a unit with an amplifier for each gauge."""

    def answer(line: str) -> bytes:
        if line not in {VALUES, STATES_AND_VALUES}:
            return encode(
                Refused(line[:_COMMAND_CHARACTERS].ljust(_COMMAND_CHARACTERS, "?"), INVALID_COMMAND)
            )
        return encode(Amplifiers(line, tuple(map(_amplifier, gauges))))

    return box_endpoint(device, "keyence_gt2", TextBox(gauges, answer))


def _amplifier(gauge: Electronics) -> Amplifier:
    shown = gauge.show()
    if shown.signal == "none" or math.isnan(shown.deviation_mm):
        return Amplifier(None)
    number, inches = in_inches(gauge, shown)
    beyond = LOW if shown.deviation_mm < 0.0 else HIGH
    state = GO if shown.signal == "good" else beyond
    return Amplifier(Value(number, _DECIMALS_OF_INCHES if inches else _DECIMALS), state)
