"""What the parameters of a model are, in words."""

import re

from truepose.domain.sentences import Sentence, said
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_MOTION = r"(r?[xyz])"
_MEANINGS = (
    (r"base_([xyz])", "parameters.base_place"),
    (r"base_r([xyz])", "parameters.base_orientation"),
    (r"alpha_(\d+)", "parameters.alpha"),
    (r"a_(\d+)", "parameters.a"),
    (r"theta_(\d+)", "parameters.theta"),
    (r"d_(\d+)", "parameters.d"),
    (r"beta_(\d+)", "parameters.beta"),
    (r"c_(\d+)", "parameters.compliance"),
    (r"c_(\d+)\*m([xy])_(\d+)", "parameters.compliance_product"),
    (r"soft_(\d+)_(\S+)", "parameters.soft"),
    (r"gain_(\d+)", "parameters.gain"),
    (r"wave_(\d+)_(\S+)_(sin|cos)", "parameters.wave"),
    (r"coupling_(\d+)_(\d+)", "parameters.coupling"),
    (r"gap_(\d+)", "parameters.gap"),
    (r"sag_(\d+)", "parameters.sag"),
    (r"payload_mass", "parameters.payload_mass"),
    (r"payload_([xyz])", "parameters.payload_moment"),
    (r"mass_(\d+)", "parameters.link_mass"),
    (r"moment_(\d+)_([xyz])", "parameters.link_moment"),
    (r"base_c", "parameters.base_compliance"),
    (r"growth", "parameters.growth"),
    (rf"drift_linear_{_MOTION}", "parameters.base_drift"),
    (rf"drift_exp([^_]+)_{_MOTION}", "parameters.base_settling"),
    (rf"tracker_linear_{_MOTION}", "parameters.tracker_drift"),
    (rf"tracker_exp([^_]+)_{_MOTION}", "parameters.tracker_settling"),
    (rf"jump_(\S+)_{_MOTION}", "parameters.base_jump"),
    (rf"fixture_(\d+)_(\S+)_{_MOTION}", "parameters.fixture_jump"),
    (rf"seat_(\d+)_{_MOTION}", "parameters.seat"),
    (r"offset_(\d+)_([xyz])", "parameters.offset"),
    (r"nest_(\d+)_([xyz])", "parameters.nest"),
    (r"tool_r([xyz])", "parameters.tool_orientation"),
    (r"anchor_(\d+)_(\d+)_([xyz])", "parameters.anchor"),
    (r"target_(\d+)_([xyz])", "parameters.target"),
    (r"target_(\d+)_zero", "parameters.target_zero"),
    (r"target_(\d+)_shift", "parameters.target_shift"),
    (r"target_(\d+)_slope([12])", "parameters.target_slope"),
    (r"fixed_(\d+)_([xyz])", "parameters.fixed"),
    (r"zero_(\d+)", "parameters.zero"),
    (r"zerorate_(\d+)_(\S+)", "parameters.zero_rate"),
    (r"cell_(\w+?)_.*", "parameters.cell"),
    (r"length_offset", "parameters.length_offset"),
    (r"(?:ballbar_)?scale", "parameters.scale"),
)
_GROUPS = ("first", "second", "third")


def meaning(name: str, effect: str, words: Catalogue = IN_ENGLISH) -> str:
    """Return what a parameter is, in words; the name of its effect where there is none."""
    for pattern, key in _MEANINGS:
        match = re.fullmatch(pattern, name)
        if match:
            groups = match.groups()
            told = dict(zip(_GROUPS, groups, strict=False))
            return words.say(key, before=_before(groups), about=_about(groups), **told)
    return effect


def _before(groups: tuple[str, ...]) -> int:
    """Return the number before the first, for axes that are named in pairs."""
    return int(groups[0]) - 1 if groups and groups[0].isdigit() else 0


def _about(groups: tuple[str, ...]) -> Sentence:
    """Return a component of a motion in words."""
    component = groups[-1] if groups else ""
    if component.startswith("r"):
        return said("parameters.about", axis=component[1:])
    return said("parameters.along", axis=component)
