"""From what the ballbar shows to a length that can be kept: calibrator + deviation - zero."""

import math
from dataclasses import dataclass
from typing import Final

from truepose.domain.cell.artefacts import BallbarKit, Bars
from truepose.domain.measurement.ballbar import BallbarStep, LengthTaken, StepKind
from truepose.sequencing.ballbar.measuring.certificates import Papers
from truepose.sequencing.ballbar.measuring.live import Window
from truepose.sequencing.ballbar.situation import Situation
from truepose.sequencing.errors import NotNowError

_NO_ZERO: Final = "There is no zero to count from; put the ballbar on the calibrator first."


@dataclass(frozen=True, slots=True)
class Shown:
    """What the ballbar showed over a window, and what is known of it."""

    window: Window
    time_s: float
    temperature_c: float  # NaN where the ballbar has no thermometer
    papers: Papers
    by_hand: bool


def bars_of(step: BallbarStep, kit: BallbarKit) -> Bars:
    """Return what the ballbar is made up with at a step."""
    return kit.tool_bars if step.artefact == "tool" else kit.base_bars


def length_taken(shown: Shown, now: Situation, step: BallbarStep, kit: BallbarKit) -> LengthTaken:
    """Return the length that is read at this step; raises NotNowError where there is no zero."""
    bars, deviation_mm = bars_of(step, kit), shown.window.mean_mm
    if step.kind is StepKind.INITIALISE:
        zero_mm, number, u_mm = deviation_mm, now.initialisations + 1, bars.calibrator_u_mm
    elif now.zero is not None:
        zero_mm, number = now.zero.zero_mm, now.zero.initialisation
        # the mean of many samples is no better: 2 um at 95 % is what the instrument states of a length
        reading_u_mm = kit.reading_u_mm if shown.papers.hold else kit.uncertified_u_mm
        u_mm = math.hypot(reading_u_mm, kit.zero_u_mm, bars.calibrator_u_mm)
    else:
        raise NotNowError(_NO_ZERO)
    return LengthTaken(
        length_mm=bars.calibrator_mm + deviation_mm - zero_mm,
        deviation_mm=deviation_mm,
        zero_mm=zero_mm,
        standard_uncertainty_mm=u_mm,
        spread_mm=shown.window.spread_mm,
        samples=shown.window.count,
        initialisation=number,
        by_hand=shown.by_hand,
        temperature_c=shown.temperature_c,
        instrument_serial=shown.papers.serial,
        certificate=shown.papers.certificate,
        certificate_expires=shown.papers.certificate_expires,
        time_s=shown.time_s,
    )
