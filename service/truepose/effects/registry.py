"""The effects by name: one line each. Those that a diagnosis looks for stand among the causes.

Nobody else lists effects: others ask for traits and abilities (docs/decisions/0083). What packages bring is
loaded once, when this module is imported, behind guards (`installed`).
"""

from collections.abc import Mapping, Sequence
from functools import cache

from truepose.domain.campaign import Stops
from truepose.domain.errors import ConfigurationError, UnknownEffectError
from truepose.domain.identification import NotIdentifiable
from truepose.effects.arm.axis_parallelism import AxisParallelism
from truepose.effects.arm.backlash import Backlash
from truepose.effects.arm.compliance import Compliance
from truepose.effects.arm.compliance_nonlinear import ComplianceNonlinear
from truepose.effects.arm.geometry import Geometry, JointOffset
from truepose.effects.arm.joint_coupling import JointCoupling
from truepose.effects.arm.joint_gain import JointGain
from truepose.effects.arm.joint_harmonics import JointHarmonics
from truepose.effects.arm.link_bending import LinkBending
from truepose.effects.arm.link_mass import LinkMasses
from truepose.effects.arm.thermal_growth import ThermalGrowth
from truepose.effects.causes import Cause
from truepose.effects.frames.base_frame import Base
from truepose.effects.frames.fixed_nests import Reference
from truepose.effects.frames.tool_certificate import ToolCertificate
from truepose.effects.frames.tool_nests import Tool
from truepose.effects.installed import INSTALLED
from truepose.effects.ports import (
    Automatic,
    Compliant,
    Discrepancy,
    Drifting,
    Effect,
    EffectWithTraits,
    LeavesOpen,
    Need,
    Setting,
    Summed,
    Trait,
)
from truepose.effects.readings.label_swap import LabelSwap
from truepose.effects.readings.outliers import Outliers
from truepose.effects.setup.ballbar_zero import BallbarZero
from truepose.effects.setup.base_compliance import BaseCompliance
from truepose.effects.setup.base_drift import BaseDrift
from truepose.effects.setup.base_shift import BaseShift
from truepose.effects.setup.fixture_shift import FixtureShift
from truepose.effects.setup.instrument_drift import InstrumentDrift
from truepose.effects.setup.instrument_scale import InstrumentScale
from truepose.effects.setup.nest_offset import NestOffset
from truepose.effects.setup.payload import Payload
from truepose.effects.setup.tool_reseating import ToolReseating
from truepose.effects.unclassified.cause import OWN, Unnamed

_CAUSES: tuple[Cause, ...] = (
    AxisParallelism(),
    Backlash(),
    BallbarZero(),
    BaseCompliance(),
    BaseDrift(),
    BaseShift(),
    Compliance(),
    ComplianceNonlinear(),
    FixtureShift(),
    InstrumentDrift(),
    InstrumentScale(),
    JointCoupling(),
    JointGain(),
    JointHarmonics(),
    LabelSwap(),
    LinkBending(),
    LinkMasses(),
    NestOffset(),
    Outliers(),
    Payload(),
    ThermalGrowth(),
    ToolReseating(),
    Unnamed(),
)
_EFFECTS: tuple[Effect, ...] = (
    Base(),
    Tool(),
    Geometry("geometry", tilt=True),
    Geometry("geometry_dhm", tilt=False),
    JointOffset(),
    Reference(),
    ToolCertificate(),
    *_CAUSES,
)
# A name of truepose's own stays truepose's: models that were stored with it must mean what they meant.
_OWN = frozenset(effect.name for effect in _EFFECTS)
EFFECTS = {effect.name: effect for effect in _EFFECTS} | {
    name: effect for name, effect in INSTALLED.effects.items() if name not in _OWN
}
CAUSES = {cause.name: cause for cause in _CAUSES} | {
    name: cause for name, cause in INSTALLED.causes.items() if name not in _OWN
}
_SHADOWED = (INSTALLED.effects.keys() & _OWN) | (INSTALLED.kinds.keys() & OWN.keys())
_UNUSABLE = {**INSTALLED.broken, **dict.fromkeys(_SHADOWED, "truepose has its own cause of this name")}


def unusable_causes() -> tuple[str, ...]:
    """Return one sentence for every cause or cell of another package that cannot be used."""
    return tuple(
        f"The installed cause {name!r} is not used: {why}." for name, why in sorted(_UNUSABLE.items())
    )


def chosen_effects(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names that somebody asks for, as a tuple.

    Raises
    ------
    UnknownEffectError
        One of them is no effect, or is installed and cannot be used.
    ConfigurationError
        One is named twice.
    """
    for place, name in enumerate(names):
        if effect_named(name).name in names[:place]:
            raise ConfigurationError(f"Effect {name!r} is given twice. Give it once.")
    return tuple(names)


def needs_of(effect: str, names: tuple[str, ...]) -> frozenset[Need]:
    """Return what a row must tell so that these parameters of an effect can be predicted there.

    Parameters
    ----------
    effect : str
    names : tuple of str
        Of its parameters: what a cause without a trade name needs depends on which of its cells they are of.

    Raises
    ------
    UnknownEffectError
        There is no such effect.
    """
    found = effect_named(effect)
    # What the cells need differs from kind to kind; for every other effect it is one answer.
    return found.needs_of(names) if isinstance(found, Unnamed) else found.needs


def is_unbounded_in_time(effect: str, names: tuple[str, ...]) -> bool:
    """Say whether such parameters of an effect move things ever further in time.

    Raises
    ------
    UnknownEffectError
        There is no such effect.
    """
    found = effect_named(effect)
    return isinstance(found, Drifting) and found.goes_on(names)


@cache
def effects_with(trait: Trait) -> tuple[str, ...]:
    """Return the names of the effects of which that is so.

    Parameters
    ----------
    trait : Trait
    """
    return tuple(name for name, traits in _traits().items() if trait in traits)


@cache
def _traits() -> Mapping[str, frozenset[Trait]]:
    return {name: effect.traits for name, effect in EFFECTS.items() if isinstance(effect, EffectWithTraits)}


@cache
def summed_effects() -> Mapping[str, Summed]:
    """Return the effects that add up their own terms, by name."""
    return {name: effect for name, effect in EFFECTS.items() if isinstance(effect, Summed)}


@cache
def compliant_effects() -> Mapping[str, Compliant]:
    """Return the effects by which joints yield to their load, by name."""
    return {name: effect for name, effect in EFFECTS.items() if isinstance(effect, Compliant)}


def unmodelled_in(setting: Setting, stops: Stops) -> tuple[str, ...]:
    """Return the names of the effects that may be what a model leaves out at such stops.

    Parameters
    ----------
    setting : Setting
    stops : Stops
        Where the model is to be used.
    """
    possible = ((name, effect) for name, effect in EFFECTS.items() if isinstance(effect, Discrepancy))
    return tuple(name for name, effect in possible if effect.unmodelled(setting, stops))


def automatic_in(setting: Setting) -> tuple[str, ...]:
    """Return the names of the effects that are identified where nobody says which ones are.

    Parameters
    ----------
    setting : Setting
    """
    return tuple(name for name, effect in _perhaps_automatic().items() if effect.automatic(setting))


@cache
def _perhaps_automatic() -> Mapping[str, Automatic]:
    # Kept: `isinstance` of a protocol looks at every attribute, and it was asked in every identification.
    return {name: effect for name, effect in EFFECTS.items() if isinstance(effect, Automatic)}


def undetermined_by_construction(
    effects: Sequence[str], names: tuple[str, ...], setting: Setting
) -> tuple[NotIdentifiable, ...]:
    """Return what effects leave open by their construction beside the parameters of a whole model.

    Parameters
    ----------
    effects : sequence of str
        Of the model.
    names : tuple of str
        Of all its parameters.
    setting : Setting
    """
    chosen = (effect for name, effect in EFFECTS.items() if name in effects)
    openly = (effect.left_open(names, setting) for effect in chosen if isinstance(effect, LeavesOpen))
    return tuple(entry for entries in openly for entry in entries)


def effect_named(name: str) -> Effect:
    """Return the effect of that name.

    Raises
    ------
    UnknownEffectError
        There is none, with the known ones; or it is installed and cannot be used, with the reason.
    """
    if name in _UNUSABLE and name not in EFFECTS:
        raise UnknownEffectError(f"Effect {name!r} is installed but cannot be used: {_UNUSABLE[name]}.")
    if name not in EFFECTS:
        raise UnknownEffectError(f"Unknown effect {name!r}; available effects: {', '.join(EFFECTS)}.")
    return EFFECTS[name]
