"""What runs in time or follows the temperature without a name: zeros, tools, trackers, links.

    jump, slip, kick   a joint's zero, the tool, the tracker's frame move by p from a moment on
    drift              a joint's zero moves by        rate (t - t_0)
    warm               a joint's zero moves by        rate (T - 20 degC)
    stretch            a, d of one link move by       growth (a, d) (T - 20 degC)

Times and jumps are those of `effects.motions`.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.identification import Unit
from truepose.effects.arm.thermal_growth import MATERIALS, ThermalGrowth, range_k, warmer_k
from truepose.effects.causes import Scene, has_spread
from truepose.effects.motions import (
    COMPONENTS,
    SECONDS_PER_HOUR,
    duration_s,
    gaps_of_all,
    hours_followed,
    since,
    spoken,
    tried,
)
from truepose.effects.names import joint_subject
from truepose.effects.ports import Need, Port, PortKind, Rows, motion_port
from truepose.effects.unclassified.kinds import (
    ALONE,
    STEADY,
    Key,
    Kind,
    Moves,
    Part,
    Place,
    Size,
    Variants,
    once,
)
from truepose.messages.message import Message, Text, message

_ZERO_RAD = np.deg2rad(0.05)  # belief, also per h: five times a zero that an operator would notice at once
_SLIP_MM, _SLIP_RAD = 0.5, 5e-3  # belief: five times what a loose seat lets a tool slip by
_KICK_MM, _KICK_RAD = 0.5, 5e-4  # belief: a tripod that was pushed, at a few metres
_NEEDS_TIME: frozenset[Need] = frozenset({"time"})
_MOST_MOMENTS = 60  # that are tried, evenly chosen: every place of the arm tries them all


def _six(shift_mm: float, turn_rad: float) -> tuple[Part, ...]:
    units: tuple[tuple[Unit, float], ...] = (("mm", shift_mm),) * 3 + (("rad", turn_rad),) * 3
    return tuple(Part(name, *belief) for name, belief in zip(COMPONENTS, units, strict=True))


def _moments(scene: Scene) -> Variants:
    # Not at all moments: each is a candidate for every joint and the tool, and its uncertainty is told by the
    # spacing.
    return [(gap.label, gap.middle_s) for gap in tried(gaps_of_all(scene), scene.between_s, _MOST_MOMENTS)]


def _kicks(scene: Scene) -> Variants:
    """Try every moment at which the base may have jumped: at fewer, a kick would lose by that alone."""
    # At every second of them 7 of 16 kicks of 0.3 mm, with fixed nests among the readings, were told as a
    # certain jump of the base, which is tried at the moments between (docs/decisions/0029).
    return [(gap.label, gap.middle_s) for gap in tried(gaps_of_all(scene), scene.between_s)]


def _moment_known_to(time_s: float, scene: Scene) -> float:
    """Return the standard uncertainty of a moment among those that are tried here [s]."""
    return _known_to(time_s, _moments(scene))


def _kick_known_to(time_s: float, scene: Scene) -> float:
    """Return the standard uncertainty of the moment of a kick [s]."""
    return _known_to(time_s, _kicks(scene))


def _known_to(time_s: float, variants: Variants) -> float:
    """Return the standard uncertainty of a moment: it may lie anywhere between the two tried beside it.

    Evenly spread over half of the way to either neighbour: (after - before) / 2 / sqrt(12).

    Parameters
    ----------
    time_s : float
    variants : iterable of (str, float)
        Labels and moments that were tried.

    Returns
    -------
    float
        [s]; 0 where nothing else was tried.
    """
    tried = [moment_s for _, moment_s in variants]
    before = max((other for other in tried if other < time_s), default=time_s)
    after = min((other for other in tried if other > time_s), default=time_s)
    return (after - before) / 2.0 / float(np.sqrt(12.0))


def _joints(scene: Scene) -> list[Place]:
    timed = has_spread(scene.stops.time_s)
    # Joints that do not turn are asked as well: their zeros jump and drift all the same.
    return [(joint + 1,) for joint in range(scene.setting.robot.n_joints)] if timed else []


def _tool(scene: Scene) -> list[Place]:
    return [ALONE] if has_spread(scene.stops.time_s) else []


def _tracker(scene: Scene) -> list[Place]:
    # A ballbar has no frame that could be kicked.
    return [] if scene.legs else _tool(scene)


def _theta(key: Key) -> Port:
    return Port(PortKind.THETA, key.place[0] - 1)


def _zero_jumps(key: Key, rows: Rows) -> Moves:
    return [(_theta(key), since(rows, float(key.variant)))]


def _zero_drifts(key: Key, rows: Rows) -> Moves:
    hours: FloatArray = np.nan_to_num(hours_followed(rows))
    return [(_theta(key), hours)]


def _tool_slips(key: Key, rows: Rows) -> Moves:
    port = motion_port(rows.robot.n_joints, COMPONENTS.index(key.part))
    return [(port, since(rows, float(key.variant)))]


def _tracker_jumps(key: Key, rows: Rows) -> Moves:
    port = Port(PortKind.INSTRUMENT, COMPONENTS.index(key.part))
    return [(port, since(rows, float(key.variant)))]


def _after(key: Key, scene: Scene) -> Message:
    return spoken(float(key.variant) - scene.origin_s)


def _of_jump(key: Key, size: Size, scene: Scene) -> Message:
    joint, after = _of_joint(key.place), _after(key, scene)
    return message("causes.zero_jump", joint=joint, turn_deg=size.amplitude, after=after)


def _of_drift(key: Key, size: Size, scene: Scene) -> Message:
    lasted_s = duration_s(scene)
    return message(
        "causes.zero_drift",
        joint=_of_joint(key.place),
        rate_deg_per_h=size.amplitude,
        way_deg=size.amplitude * lasted_s / SECONDS_PER_HOUR,
        span=spoken(lasted_s),
    )


def _of_slip(key: Key, size: Size, scene: Scene) -> Message:
    after = _after(key, scene)
    return message("causes.tool_slip", shift_mm=size.amplitude, turn_deg=size.beside, after=after)


def _of_kick(key: Key, size: Size, scene: Scene) -> Message:
    after = _after(key, scene)
    return message("causes.instrument_kick", shift_mm=size.amplitude, turn_deg=size.beside, after=after)


def _of_joint(place: Place) -> str:
    return joint_subject(place[0] - 1)


_OF_TIME = (
    Kind(
        "jump", "jump", (Part("turn", "rad", _ZERO_RAD),), _of_joint, once("time"),
        _joints, _moments, _zero_jumps, _of_jump, ("time", "s"), _moment_known_to, needs=_NEEDS_TIME,
    ),
    Kind(
        "drift", "drift", (Part("turn", "rad/h", _ZERO_RAD),), _of_joint, once("time"),
        _joints, lambda _scene: STEADY, _zero_drifts, _of_drift, needs=_NEEDS_TIME,
    ),
    Kind(
        "slip", "jump", _six(_SLIP_MM, _SLIP_RAD), once("tool"), once("time"),
        _tool, _moments, _tool_slips, _of_slip, ("time", "s"), _moment_known_to, needs=_NEEDS_TIME,
    ),
    Kind(
        "kick", "jump", _six(_KICK_MM, _KICK_RAD), once("tracker"), once("time"),
        _tracker, _kicks, _tracker_jumps, _of_kick, ("time", "s"), _kick_known_to, needs=_NEEDS_TIME,
    ),
)  # fmt: skip


_ZERO_RAD_PER_K = np.deg2rad(0.01)  # belief: five times a joint that visibly warms up
_NEEDS_TEMPERATURE: frozenset[Need] = frozenset({"temperature"})
_GROWTH_PER_K = 2.5e-5  # belief: what aluminium grows by, twice what steel does


def _warmed(scene: Scene) -> bool:
    return ThermalGrowth().unseen(scene) is None


def _warm_joints(scene: Scene) -> list[Place]:
    return [(joint + 1,) for joint in range(scene.setting.robot.n_joints)] if _warmed(scene) else []


def _links(scene: Scene) -> list[Place]:
    """Links that have a length; all of one alone are the thermal growth of all links."""
    rows = scene.setting.robot.joints
    found = [(link,) for link, row in enumerate(rows) if row.a_mm != 0.0 or row.d_mm != 0.0]
    return list(found) if _warmed(scene) and len(found) > 1 else []


def _zero_warms(key: Key, rows: Rows) -> Moves:
    return [(Port(PortKind.THETA, key.place[0] - 1), warmer_k(rows.stops))]


def _link_grows(key: Key, rows: Rows) -> Moves:
    link = key.place[0]
    row, warmer = rows.robot.joints[link], warmer_k(rows.stops)
    return [(Port(PortKind.A, link), row.a_mm * warmer), (Port(PortKind.D, link), row.d_mm * warmer)]


def _link(place: Place) -> str:
    """Return the body that ends at the joint whose row has the lengths; the first stands on the base."""
    return f"link {place[0]}" if place[0] > 0 else "base"


def _of_zero(key: Key, size: Size, scene: Scene) -> Message:
    way_deg = size.amplitude * range_k(scene.stops)
    joint = joint_subject(key.place[0] - 1)
    return message("causes.zero_warms", joint=joint, rate_deg_per_k=size.amplitude, way_deg=way_deg)


def _of_growth(key: Key, size: Size, scene: Scene) -> Message:
    row = scene.setting.robot.joints[key.place[0]]
    length_m = float(np.hypot(row.a_mm, row.d_mm)) / 1e3
    rate_um = 1e6 * size.amplitude
    here_um = rate_um * length_m * range_k(scene.stops)
    return message("causes.link_grows", link=_who(key.place), um_per_m_k=rate_um, here_um=here_um)


def _who(place: Place) -> Text:
    return _link(place) if place[0] > 0 else message("causes.link_grows.base")


_OF_TEMPERATURE = (
    Kind(
        "warm", "line", (Part("turn", "rad/K", _ZERO_RAD_PER_K),), lambda place: joint_subject(place[0] - 1),
        once("temperature"), _warm_joints, lambda _scene: STEADY, _zero_warms, _of_zero,
        needs=_NEEDS_TEMPERATURE,
    ),
    Kind(
        "stretch", "line", (Part("growth", "1/K", _GROWTH_PER_K),), _link,
        once("temperature"), _links, lambda _scene: STEADY, _link_grows, _of_growth,
        limits=MATERIALS, needs=_NEEDS_TEMPERATURE,
    ),
)  # fmt: skip

KINDS = _OF_TIME + _OF_TEMPERATURE
