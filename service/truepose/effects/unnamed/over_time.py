"""What happens or runs in time without a name: a zero that jumps or drifts, a tool that slips, a kick."""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.identification import Unit
from truepose.domain.sentences import Sentence, said
from truepose.effects.causes import Scene, varied
from truepose.effects.names import joint_subject
from truepose.effects.ports import Need, Port, PortKind, Rows, motion_port
from truepose.effects.shapes.jumps import gaps_of_all, since, tried
from truepose.effects.shapes.rigid_motion import COMPONENTS
from truepose.effects.shapes.times import SECONDS_PER_HOUR, duration_s, hours_followed, spoken
from truepose.effects.unnamed.kinds import ALONE, STEADY, Key, Kind, Moves, Part, Place, Size, Variants, once

_ZERO_RAD = np.deg2rad(0.05)  # belief, also per h: five times a zero that an operator would notice at once
_SLIP_MM, _SLIP_RAD = 0.5, 5e-3  # belief: five times what a loose seat lets a tool slip by
_KICK_MM, _KICK_RAD = 0.5, 5e-4  # belief: a tripod that was pushed, at a few metres
_NEEDS: frozenset[Need] = frozenset({"time"})
_MOST_MOMENTS = 60  # that are tried, evenly chosen: every place of the arm tries them all


def _six(shift_mm: float, turn_rad: float) -> tuple[Part, ...]:
    units: tuple[tuple[Unit, float], ...] = (("mm", shift_mm),) * 3 + (("rad", turn_rad),) * 3
    return tuple(Part(name, *belief) for name, belief in zip(COMPONENTS, units, strict=True))


def _moments(scene: Scene) -> Variants:
    return [(gap.label, gap.middle_s) for gap in tried(gaps_of_all(scene), scene.between_s, _MOST_MOMENTS)]


def _kicks(scene: Scene) -> Variants:
    """Try every moment at which the base may have jumped: at fewer, a kick would lose by that alone."""
    return [(gap.label, gap.middle_s) for gap in tried(gaps_of_all(scene), scene.between_s)]


def _moment_known_to(time_s: float, scene: Scene) -> float:
    return _known_to(time_s, _moments(scene))


def _kick_known_to(time_s: float, scene: Scene) -> float:
    return _known_to(time_s, _kicks(scene))


def _known_to(time_s: float, variants: Variants) -> float:
    """Return the standard uncertainty of a moment: it may lie anywhere between the two tried beside it."""
    tried = [moment_s for _, moment_s in variants]
    before = max((other for other in tried if other < time_s), default=time_s)
    after = min((other for other in tried if other > time_s), default=time_s)
    return (after - before) / 2.0 / float(np.sqrt(12.0))


def _joints(scene: Scene) -> list[Place]:
    timed = varied(scene.stops.time_s)
    return [(joint + 1,) for joint in range(scene.setting.robot.n_joints)] if timed else []


def _tool(scene: Scene) -> list[Place]:
    return [ALONE] if varied(scene.stops.time_s) else []


def _tracker(scene: Scene) -> list[Place]:
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


def _after(key: Key, scene: Scene) -> Sentence:
    return spoken(float(key.variant) - scene.origin_s)


def _of_jump(key: Key, size: Size, scene: Scene) -> Sentence:
    joint, after = _of_joint(key.place), _after(key, scene)
    return said("causes.zero_jump", joint=joint, turn_deg=size.amplitude, after=after)


def _of_drift(key: Key, size: Size, scene: Scene) -> Sentence:
    lasted_s = duration_s(scene)
    return said(
        "causes.zero_drift",
        joint=_of_joint(key.place),
        rate_deg_per_h=size.amplitude,
        way_deg=size.amplitude * lasted_s / SECONDS_PER_HOUR,
        span=spoken(lasted_s),
    )


def _of_slip(key: Key, size: Size, scene: Scene) -> Sentence:
    after = _after(key, scene)
    return said("causes.tool_slip", shift_mm=size.amplitude, turn_deg=size.beside, after=after)


def _of_kick(key: Key, size: Size, scene: Scene) -> Sentence:
    after = _after(key, scene)
    return said("causes.instrument_kick", shift_mm=size.amplitude, turn_deg=size.beside, after=after)


def _of_joint(place: Place) -> str:
    return joint_subject(place[0] - 1)


KINDS = (
    Kind(
        "jump", "jump", (Part("turn", "rad", _ZERO_RAD),), _of_joint, once("time"),
        _joints, _moments, _zero_jumps, _of_jump, ("time", "s"), _moment_known_to, needs=_NEEDS,
    ),
    Kind(
        "drift", "drift", (Part("turn", "rad/h", _ZERO_RAD),), _of_joint, once("time"),
        _joints, lambda _scene: STEADY, _zero_drifts, _of_drift, needs=_NEEDS,
    ),
    Kind(
        "slip", "jump", _six(_SLIP_MM, _SLIP_RAD), once("tool"), once("time"),
        _tool, _moments, _tool_slips, _of_slip, ("time", "s"), _moment_known_to, needs=_NEEDS,
    ),
    Kind(
        "kick", "jump", _six(_KICK_MM, _KICK_RAD), once("tracker"), once("time"),
        _tracker, _kicks, _tracker_jumps, _of_kick, ("time", "s"), _kick_known_to, needs=_NEEDS,
    ),
)  # fmt: skip
