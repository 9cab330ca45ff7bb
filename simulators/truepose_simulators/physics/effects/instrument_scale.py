"""An instrument whose metre is wrong: wavelength and refraction, or the length of a calibrator."""

from dataclasses import dataclass

from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class WrongScale:
    """Every distance from the tracker is read too long by `share`."""

    share: float
    from_s: float

    def relative_scale(self, time_s: FloatArray) -> FloatArray:
        """Return the share, from its time on."""
        return self.share * effect.since(time_s, self.from_s)


@dataclass(frozen=True, slots=True)
class WrongCalibrator:
    """Every length of the ballbar is read too long by `share`."""

    share: float
    from_s: float

    def relative_length(self, time_s: FloatArray) -> FloatArray:
        """Return the share, from its time on."""
        return self.share * effect.since(time_s, self.from_s)


def plant(change: effect.PlantedChange, site: effect.Site) -> WrongScale | WrongCalibrator:
    """Build the effect; the amplitude is read over true length, less one."""
    del site
    effect.check_one_of(change, "tracker", "ballbar")
    effect.read_details(effect.NoDetails, change)
    kind = WrongScale if change.subject == "tracker" else WrongCalibrator
    return kind(change.amplitude, change.from_s)


def realise(
    stated: effect.IdentifiedEffect, site: effect.ModelArm
) -> tuple[WrongScale | WrongCalibrator, ...]:
    """Build the identified scale, `scale` of a tracker or `ballbar_scale` [1]."""
    del site
    scales = stated.matching("(ballbar_)?scale", "scale, ballbar_scale")
    return tuple(
        WrongCalibrator(value, effect.ALWAYS_S) if ballbar else WrongScale(value, effect.ALWAYS_S)
        for (ballbar,), value in scales
    )
