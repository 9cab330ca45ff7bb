"""Scripted failures of wires, keys and other programs: what a driver must not take for a reading."""

from typing import TypeAlias

from truepose_simulators.faults.times import AtReading, Lasting


class BallbarFrozen(Lasting):
    """The ballbar's electronics hang: value and count stay as they were."""


class BallbarInches(Lasting):
    """Somebody switched the gauge to inches, where its protocol has them."""


class BallbarKeyPressed(Lasting):
    """Somebody presses the key that sends a value, before each question to the gauge."""


class LineStalls(Lasting):
    """The lines of counter and robot stall for 50 ms in the middle of every answer."""


class LineDoublesDigits(Lasting):
    """The gauge's line delivers the first digit of every value twice."""


class CameraFrozen(Lasting):
    """The camera hangs: it answers, and states the same frame again and again."""


class TrackerUnitsChanged(AtReading):
    """Another program sets inches during a measurement; announced where asked for."""


class TrackerRepeatsResult(AtReading):
    """A measurement is answered with the result of the one before."""


class TrackerStaleResult(AtReading):
    """The result of the measurement before comes once more, just before the next one is accepted."""


WireFault: TypeAlias = (
    BallbarFrozen | BallbarInches | BallbarKeyPressed | LineStalls | LineDoublesDigits | CameraFrozen
)
