"""An instrument whose metre is wrong: wavelength and refraction, or the length of a calibrator."""

from dataclasses import dataclass

from truepose_simulators.physics.effects.effect import PlantedChange, since
from truepose_simulators.physics.effects.site import NoDetails, Site, read_details
from truepose_simulators.physics.effects.stated import ALWAYS_S, ModelArm, Stated
from truepose_simulators.physics.effects.subject import check_one_of
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class WrongScale:
    """Every distance from the tracker is read too long by `share`."""

    share: float
    from_s: float

    def relative_scale(self, time_s: FloatArray) -> FloatArray:
        """Return the share, from its time on."""
        return self.share * since(time_s, self.from_s)


@dataclass(frozen=True, slots=True)
class WrongCalibrator:
    """Every length of the ballbar is read too long by `share`."""

    share: float
    from_s: float

    def relative_length(self, time_s: FloatArray) -> FloatArray:
        """Return the share, from its time on."""
        return self.share * since(time_s, self.from_s)


def plant(change: PlantedChange, site: Site) -> WrongScale | WrongCalibrator:
    """Build the effect; the amplitude is read over true length, less one."""
    del site
    check_one_of(change, "tracker", "ballbar")
    read_details(NoDetails, change)
    kind = WrongScale if change.subject == "tracker" else WrongCalibrator
    return kind(change.amplitude, change.from_s)


def realise(stated: Stated, site: ModelArm) -> tuple[WrongScale | WrongCalibrator, ...]:
    """Build the identified scale, `scale` of a tracker or `ballbar_scale` [1]."""
    del site
    scales = stated.matching("(ballbar_)?scale", "scale, ballbar_scale")
    return tuple(
        WrongCalibrator(value, ALWAYS_S) if ballbar else WrongScale(value, ALWAYS_S)
        for (ballbar,), value in scales
    )
