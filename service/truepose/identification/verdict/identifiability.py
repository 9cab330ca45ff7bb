"""Which parameters, or combinations of them, the data do not determine, and why.

A direction is undetermined when its standard uncertainty exceeds half its stated prior width: the
eigenvectors of the posterior covariance, scaled by the widths, with eigenvalues above one quarter.
They span a space; a sparse basis of it (one pivot parameter each, found by column-pivoted QR) says
which parameters are seen only together.
"""

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.results.identification import NotIdentifiable
from truepose.domain.sentences import Sentence, said
from truepose.effects.base.base_frame import PARAMETERS as BASE
from truepose.effects.ports import Setting, Trait
from truepose.effects.registry import effects_with, left_open_by
from truepose.identification.model.parameters.counterparts import certified_zeros
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.verdict.size import size_left_open, without

UNDETERMINED = 0.5  # of the prior width: what is not known better, the data leave open
_TOGETHER = 0.05  # share of the largest motion at which a parameter takes part in a combination

# By whether there is one unknown nest, and whether the zero of the last joint takes part.
_TOOL_AND_LAST = {
    (True, True): "open.nest_and_zero",
    (True, False): "open.nest_and_length",
    (False, True): "open.nests_and_zero",
    (False, False): "open.nests_and_length",
}
_BASE_OF_CUPS = NotIdentifiable(
    BASE,
    said("open.base_of_cups"),
)
_BASE_OF_TARGETS = NotIdentifiable(BASE, said("open.base_of_targets"))


def not_identifiable(
    structure: Structure,
    covariance: FloatArray,
    jacobian: FloatArray,
    setting: Setting,
    moved: BoolArray,
) -> tuple[NotIdentifiable, ...]:
    """Name what the data leave open.

    Parameters
    ----------
    structure : Structure
        With the stated prior widths.
    covariance : ndarray, shape (P, P)
        Posterior with exactly these widths.
    jacobian : ndarray, shape (P, m)
        Whitened derivatives.
    setting : Setting
    moved : ndarray, shape (J,)
        Whether each joint moved.

    Returns
    -------
    tuple of NotIdentifiable
        By construction first, then what these configurations leave open.
    """
    built_in = _by_construction(structure, setting)
    return (*built_in, *left_open(structure, covariance, jacobian, moved))


def left_open(
    structure: Structure, covariance: FloatArray, jacobian: FloatArray, moved: BoolArray
) -> tuple[NotIdentifiable, ...]:
    """Name what these configurations leave open, others need not; parameters as above."""
    # What the readings leave open of a place within its certificate is nobody's question.
    certificates = effects_with(Trait.NUISANCE)
    held = certified_zeros(structure)
    own = np.array(
        [
            owner not in certificates and name not in held
            for name, owner in zip(structure.names, structure.owners, strict=True)
        ],
        dtype=bool,
    )
    asked = structure.kept(np.flatnonzero(own))
    found = _by_data(asked, covariance[np.ix_(own, own)], jacobian[own], moved)
    return tuple(found)


def _by_construction(structure: Structure, setting: Setting) -> tuple[NotIdentifiable, ...]:
    """Return what effects, unknown cups and targets of unknown place leave open whatever is read."""
    entries = left_open_by(structure.effects, structure.names, setting)
    if structure.targets:
        return (_BASE_OF_TARGETS, *entries)
    return (_BASE_OF_CUPS, *entries) if structure.anchors else entries


def _by_data(
    structure: Structure, covariance: FloatArray, jacobian: FloatArray, moved: BoolArray
) -> list[NotIdentifiable]:
    widths = structure.prior_widths
    scaled = covariance / np.outer(widths, widths)
    eigenvalues, vectors = np.linalg.eigh(scaled)
    open_space = vectors[:, eigenvalues > UNDETERMINED**2]
    size = size_left_open(structure, eigenvalues, vectors)
    entries = [] if size is None else [_of_size(size * widths, jacobian, structure)]
    open_space = open_space if size is None else without(open_space, size)
    if open_space.shape[1] == 0:
        return entries
    for direction in _sparse_basis(open_space):
        members = _members(direction * widths, jacobian, structure)
        entry = NotIdentifiable(members, _reason(members, structure, moved))
        if entry not in entries:
            entries.append(entry)
    return entries


def _of_size(direction: FloatArray, jacobian: FloatArray, structure: Structure) -> NotIdentifiable:
    return NotIdentifiable(_members(direction, jacobian, structure), said("open.size"))


def _sparse_basis(space: FloatArray) -> FloatArray:
    """Directions in rows, shape (k, P), each alone in moving its pivot parameter."""
    return np.asarray((space @ np.linalg.inv(space[_pivots(space)])).T)


def _pivots(space: FloatArray) -> list[int]:
    """Return one row for each column: every time the longest of what the rows before leave (pivoted QR)."""
    left, pivots = space, list[int]()
    for _ in range(space.shape[1]):
        lengths = np.linalg.norm(left, axis=1)
        pivots.append(int(lengths.argmax()))
        direction = left[pivots[-1]] / lengths.max()
        left = left - np.outer(left @ direction, direction)
    return pivots


def _members(direction: FloatArray, jacobian: FloatArray, structure: Structure) -> tuple[str, ...]:
    """Parameters that take part: each alone would move the predictions, together they hardly do."""
    motion = np.linalg.norm(jacobian, axis=1) * np.abs(direction)
    by_width = np.abs(direction) / structure.prior_widths
    # A parameter that moves nothing at all is open by itself; its weight in the direction says so.
    taking_part = (motion > _TOGETHER * motion.max()) | ((motion < 1e-9) & (by_width > 0.5))
    if motion.max() < 1e-9:
        taking_part = by_width > 0.5
    return tuple(name for name, part in zip(structure.names, taking_part, strict=True) if part)


def _reason(members: tuple[str, ...], structure: Structure, moved: BoolArray) -> Sentence:
    still = [k + 1 for k in range(structure.robot.n_joints) if not moved[k]]
    joints_named = {int(name.split("*")[0].rsplit("_", 1)[1]) for name in members if _of_joint(name)}
    nests = sorted({name.split("_")[1] for name in members if name.startswith("nest_")})
    last = structure.robot.n_joints
    if {"length_offset", *(name for name in members if name.startswith("anchor_"))} & set(members):
        return said("open.anchor")
    if any(name.startswith("target_") for name in members):
        return said("open.target")
    if "scale" in members:
        return said("open.scale")
    if nests and {f"theta_{last}", f"d_{last}"} & set(members) and not set(still) & joints_named:
        return said(_TOOL_AND_LAST[len(nests) == 1, f"theta_{last}" in members], joint=last)
    if any("*" in name for name in members):
        return said("open.products")
    standing = sorted({joint for joint in still if joint in joints_named or joint + 1 in joints_named})
    if standing:
        key = "open.standing_joint" if len(standing) == 1 else "open.standing_joints"
        return said(key, joints=tuple(standing))
    if any(name.startswith("c_") for name in members) and len(members) > 1:
        return said("open.springs_alike")
    if len(members) == 1:
        return said("open.prior_holds_it")
    return said("open.combination")


def _of_joint(name: str) -> bool:
    quantity = name.split("*")[0].rsplit("_", 1)[0]
    return quantity in ("alpha", "a", "beta", "theta", "d", "c", "gain")
