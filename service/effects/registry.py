"""The effects by name: one line each."""

from service.domain.errors import UnknownEffectError
from service.effects.base import Base
from service.effects.compliance import Compliance
from service.effects.geometry import Geometry, JointOffset
from service.effects.instrument_scale import InstrumentScale
from service.effects.joint_gain import JointGain
from service.effects.ports import Effect
from service.effects.tool import Tool

_EFFECTS: tuple[Effect, ...] = (
    Base(),
    Tool(),
    Geometry("geometry", tilt=True),
    Geometry("geometry_dhm", tilt=False),
    JointOffset(),
    Compliance(),
    JointGain(),
    InstrumentScale(),
)
EFFECTS = {effect.name: effect for effect in _EFFECTS}


def effect_named(name: str) -> Effect:
    """Return the effect of that name; raises UnknownEffectError, which lists the known ones."""
    if name not in EFFECTS:
        raise UnknownEffectError(f"There is no effect {name!r}; known are {', '.join(EFFECTS)}.")
    return EFFECTS[name]
