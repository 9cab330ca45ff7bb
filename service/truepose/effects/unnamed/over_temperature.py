"""What follows the temperature without a name: the zero of one joint, the lengths of one link."""

import numpy as np

from truepose.domain.sentences import Sentence, Text, said
from truepose.effects.causes import Scene
from truepose.effects.links.thermal_growth import MATERIALS, ThermalGrowth, range_k, warmer_k
from truepose.effects.names import joint_subject
from truepose.effects.ports import Need, Port, PortKind, Rows
from truepose.effects.unnamed.kinds import STEADY, Key, Kind, Moves, Part, Place, Size, once

_ZERO_RAD_PER_K = np.deg2rad(0.01)  # belief: five times a joint that visibly warms up
_NEEDS: frozenset[Need] = frozenset({"temperature"})
_GROWTH_PER_K = 2.5e-5  # belief: what aluminium grows by, twice what steel does


def _warmed(scene: Scene) -> bool:
    return ThermalGrowth().unseen(scene) is None


def _joints(scene: Scene) -> list[Place]:
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


def _of_zero(key: Key, size: Size, scene: Scene) -> Sentence:
    way_deg = size.amplitude * range_k(scene.stops)
    joint = joint_subject(key.place[0] - 1)
    return said("causes.zero_warms", joint=joint, rate_deg_per_k=size.amplitude, way_deg=way_deg)


def _of_growth(key: Key, size: Size, scene: Scene) -> Sentence:
    row = scene.setting.robot.joints[key.place[0]]
    length_m = float(np.hypot(row.a_mm, row.d_mm)) / 1e3
    rate_um = 1e6 * size.amplitude
    here_um = rate_um * length_m * range_k(scene.stops)
    return said("causes.link_grows", link=_who(key.place), um_per_m_k=rate_um, here_um=here_um)


def _who(place: Place) -> Text:
    return _link(place) if place[0] > 0 else said("causes.link_grows.base")


KINDS = (
    Kind(
        "warm", "line", (Part("turn", "rad/K", _ZERO_RAD_PER_K),), lambda place: joint_subject(place[0] - 1),
        once("temperature"), _joints, lambda _scene: STEADY, _zero_warms, _of_zero, needs=_NEEDS,
    ),
    Kind(
        "stretch", "line", (Part("growth", "1/K", _GROWTH_PER_K),), _link,
        once("temperature"), _links, lambda _scene: STEADY, _link_grows, _of_growth,
        limits=MATERIALS, needs=_NEEDS,
    ),
)  # fmt: skip
