"""A camera that measures poses, and the artefact that it follows, as a cell file describes them.

Accuracies are those of the nests' coordinates, as makers state them; what they mean for a pose follows from
where the nests are. The artefact's centre becomes one more nest: there a pose's position and its orientation
share no error.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell import Camera, Cell, Vector
from truepose.domain.robot import Nest
from truepose.exchange.cells.sections import read_cone, refuse_unlisted
from truepose.exchange.document import TRUTH, VECTOR, Form, Key, Node, number, read_keys
from truepose.kinematics.poses import centre, normal, pose_uncertainty

_FEWEST_NESTS: Final = 3
_LEAST_SPREAD_MM: Final = 10.0  # across their longest line; below it they tell no turn about it
_LENGTH: Final = number(above=0.0)


@dataclass(frozen=True, slots=True)
class _Section:
    position_mm: Vector
    looks_at_mm: Vector
    reading_u_mm: float  # of a nest's coordinate by one reading
    artefact_u_mm: float  # of a nest's coordinate in the artefact's definition
    seen_within_rad: float | None  # of the artefact's normal; None: from all sides
    upright: bool


_SECTION: Final = (
    Key("position_mm", "position_mm", VECTOR),
    Key("looks_at_mm", "looks_at_mm", VECTOR),
    Key("reading_u_mm", "reading_u_mm", _LENGTH),
    Key("artefact_u_mm", "artefact_u_mm", _LENGTH),
    Key("seen_within_deg", "seen_within_rad", Form(read_cone), absent=None),
    Key("upright", "upright", TRUTH, absent=False),
)


def before_camera(cell: Cell, node: Node) -> Cell:
    """Return a cell whose artefact a camera follows, as the section says; raises an InputFileError."""
    refuse_unlisted(node, [key.name for key in _SECTION])
    said = _Section(**read_keys(node, _SECTION))
    # The camera's own level is taken from the world's z: along that there is none.
    if said.position_mm[:2] == said.looks_at_mm[:2]:
        node.key("looks_at_mm").fail(
            "the camera would look straight up or down, which leaves its roll undefined"
        )
    nests_mm = _nests(cell, node)
    read, defined = (pose_uncertainty(nests_mm, u_mm) for u_mm in (said.reading_u_mm, said.artefact_u_mm))
    # The nests of an artefact that is seen from all sides face nowhere; of a flat one they face along its
    # normal.
    facing = None if said.seen_within_rad is None else _vector(normal(nests_mm))
    shown = Nest(_vector(centre(nests_mm)), defined.position_mm, facing)
    camera = Camera(
        position_mm=said.position_mm,
        looks_at_mm=said.looks_at_mm,
        nest=len(cell.nests) + 1,
        position_u_mm=read.position_mm,
        rotation_u_rad=read.rotation_rad,
        artefact_rotation_u_rad=defined.rotation_rad,
        upright=said.upright,
    )
    return replace(
        cell,
        camera=camera,
        nests=(*cell.nests, shown),
        tracker_position_mm=said.position_mm,
        limits=replace(cell.limits, seen_within_rad=said.seen_within_rad),
    )


def _nests(cell: Cell, node: Node) -> FloatArray:
    known = [nest.centre_mm for nest in cell.nests if nest.centre_mm is not None]
    if len(known) < _FEWEST_NESTS or len(known) < len(cell.nests):
        node.fail(f"an artefact needs {_FEWEST_NESTS} tool nests, all with a centre; {len(known)} have one")
    nests_mm = np.array(known)
    if np.linalg.svd(nests_mm - centre(nests_mm), compute_uv=False)[1] < _LEAST_SPREAD_MM:
        node.fail("the tool nests lie on a line, which does not determine a pose")
    return nests_mm


def _vector(values: FloatArray) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
