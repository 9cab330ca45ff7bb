"""What the parameters of a model are, in words."""

import re

_MOTION = r"(r?[xyz])"
_MEANINGS = (
    (r"base_([xyz])", "place of the robot's base in the world, {0}"),
    (r"base_r([xyz])", "orientation of the robot's base in the world, about {0}"),
    (r"alpha_(\d+)", "angle between axes {before} and {0} (DH-Modified)"),
    (r"a_(\d+)", "distance between axes {before} and {0} (DH-Modified)"),
    (r"theta_(\d+)", "zero of joint {0} (DH-Modified)"),
    (r"d_(\d+)", "offset along axis {0} (DH-Modified)"),
    (r"beta_(\d+)", "tilt of axis {0} out of the plane it shares with axis {before}, about y (Hayati)"),
    (r"c_(\d+)", "compliance of gearbox {0}: angle per torque about its axis"),
    (r"c_(\d+)\*m([xy])_(\d+)", "compliance of gearbox {0} times the mass moment about {1} in frame {2}"),
    (r"soft_(\d+)_(\S+)", "additional compliance of gearbox {0} near zero torque; gone beyond {1} N·mm"),
    (r"gain_(\d+)", "joint {0} turns by this share more than it should"),
    (r"wave_(\d+)_(\S+)_(sin|cos)", "error of joint {0} over its own angle: {2} of {1} periods per turn"),
    (r"coupling_(\d+)_(\d+)", "joint {0} moves by this share of the angle of joint {1}"),
    (r"gap_(\d+)", "backlash of joint {0}: full gap between the two directions of approach"),
    (r"sag_(\d+)", "bending of link {0}: one over its flexural rigidity"),
    (r"payload_mass", "mass of the tool beyond what is stated"),
    (r"payload_([xyz])", "mass moment of the tool beyond what is stated, {0} in its frame"),
    (r"mass_(\d+)", "mass of link {0} beyond what is stated"),
    (r"moment_(\d+)_([xyz])", "mass moment of link {0} beyond what is stated, {1} in its frame"),
    (r"base_c", "tilt of the base per moment that the arm puts on it"),
    (r"growth", "growth of all lengths of the arm per kelvin"),
    (rf"drift_linear_{_MOTION}", "even motion of the base, {about}"),
    (rf"drift_exp([^_]+)_{_MOTION}", "motion of the base that settles within about {0} s, {about}"),
    (rf"tracker_linear_{_MOTION}", "even motion of the instrument, {about}"),
    (rf"tracker_exp([^_]+)_{_MOTION}", "motion of the instrument that settles within about {0} s, {about}"),
    (rf"jump_(\S+)_{_MOTION}", "jump of the base between two readings, {about}"),
    (rf"fixture_(\d+)_(\S+)_{_MOTION}", "jump of the base fixture during placement {0}, {about}"),
    (rf"seat_(\d+)_{_MOTION}", "seat of the tool at mounting {0}, {about}"),
    (r"offset_(\d+)_([xyz])", "tool nest {0} away from its certified place, {1}"),
    (r"nest_(\d+)_([xyz])", "tool nest {0} in the last frame, {1}"),
    (r"tool_r([xyz])", "orientation of the tool, about {0}"),
    (r"anchor_(\d+)_(\d+)_([xyz])", "base nest {1} of placement {0} in the world, {2}"),
    (r"fixed_(\d+)_([xyz])", "fixed nest {0} away from its certified place, {1}"),
    (r"zero_(\d+)", "added to every length after initialisation {0}"),
    (r"zerorate_(\d+)_(\S+)", "growth of the ballbar's zero after initialisation {0}"),
    (r"cell_(\w+?)_.*", "part of a cause that has no name of its own"),
    (r"length_offset", "added to every length"),
    (r"(?:ballbar_)?scale", "lengths of the instrument are off by this share"),
)


def meaning(name: str, effect: str) -> str:
    """Return what a parameter is, in words; the name of its effect where there is none."""
    for pattern, words in _MEANINGS:
        match = re.fullmatch(pattern, name)
        if match:
            groups = match.groups()
            return words.format(*groups, before=_before(groups), about=_about(groups))
    return effect


def _before(groups: tuple[str, ...]) -> int:
    """Return the number before the first, for axes that are named in pairs."""
    return int(groups[0]) - 1 if groups and groups[0].isdigit() else 0


def _about(groups: tuple[str, ...]) -> str:
    """Return a component of a motion in words."""
    component = groups[-1] if groups else ""
    return f"about {component[1:]}" if component.startswith("r") else f"along {component}"
