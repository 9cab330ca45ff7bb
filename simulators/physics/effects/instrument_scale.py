"""A tracker whose metre is wrong: wavelength, refraction, a worn distance meter."""

from dataclasses import dataclass

from simulators.physics.effects.effect import PlantedChange, since
from simulators.physics.effects.site import NoDetails, Site, read_details
from simulators.physics.effects.stated import ALWAYS_S, ModelArm, Stated
from simulators.physics.effects.subject import check_only
from simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class WrongScale:
    """Every distance from the tracker is read too long by `share`."""

    share: float
    from_s: float

    def relative_scale(self, time_s: FloatArray) -> FloatArray:
        """Return the share, from its time on."""
        return self.share * since(time_s, self.from_s)


def plant(change: PlantedChange, site: Site) -> WrongScale:
    """Build the effect; the amplitude is read over true length, less one."""
    del site
    check_only(change, "tracker")
    read_details(NoDetails, change)
    return WrongScale(change.amplitude, change.from_s)


def realise(stated: Stated, site: ModelArm) -> tuple[WrongScale, ...]:
    """Build the identified scale, `scale` [1]."""
    del site
    return tuple(WrongScale(value, ALWAYS_S) for _, value in stated.matching("scale", "scale"))
