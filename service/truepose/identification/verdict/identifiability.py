"""Which parameters, or combinations of them, the data do not determine, and why.

With the posterior covariance C of the parameters and their stated prior widths w,

    C~ = C / (w w') = V diag(l) V'

a direction of V is undetermined when its standard uncertainty exceeds half its stated prior width: l > 1/4
(docs/decisions/0004). These span a space; a sparse basis of it (one pivot parameter each, found by
column-pivoted QR) says which parameters are seen only together.

*Size of a closed loop.* Contacts with targets of unknown place are the same for an arm whose lengths, tool,
targets and zeros are all larger by a factor, but for readings of a known size, which are small. Source: J. M.
Hollerbach, C. W. Wampler, Int. J. Robotics Research 15(6), 1996, 573-591 (a loop without a length has no
scale). The direction of the size is, over the widths,

    s = (a_i / w(a_i), d_i / w(d_i), 0 elsewhere) / |...|
"""

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.identification import NotIdentifiable
from truepose.effects.frames.base_frame import PARAMETERS as BASE
from truepose.effects.ports import Setting, Trait
from truepose.effects.registry import effects_with, undetermined_by_construction
from truepose.identification.model.structure import Structure, certified_zeros
from truepose.messages.message import Message, message

_ALIKE = 0.9  # cosine between a direction that is left open and that of the size
# Of the prior width, which lets arms be a thousandth too large: what is not known better than to two in ten
# thousand is off by a tenth of a millimetre at half a metre, more than all the rest of a loop.
_HARDLY_KNOWN = 0.2


def size_direction(structure: Structure) -> FloatArray | None:
    """Return how the parameters grow with the size of the arm.

    Parameters
    ----------
    structure : Structure
        With the stated prior widths.

    Returns
    -------
    ndarray, shape (P,), or None
        Unit vector over the prior widths [1]; None where nothing of a length is a parameter.
    """
    joints = structure.robot.joints
    # Relative to the nominal lengths: what is 0 in the table does not grow.
    lengths = {f"a_{k}": row.a_mm for k, row in enumerate(joints, start=1)}
    lengths |= {f"d_{k}": row.d_mm for k, row in enumerate(joints, start=1)}
    grown = np.array([lengths.get(name, 0.0) for name in structure.names]) / structure.prior_widths
    total = float(np.linalg.norm(grown))
    return grown / total if total > 0.0 else None


def size_left_open(structure: Structure, variances: FloatArray, directions: FloatArray) -> FloatArray | None:
    """Return the direction of the size where it is hardly known.

    Parameters
    ----------
    structure : Structure
    variances : ndarray, shape (P,)
        Of the posterior over the prior widths, along each of its own directions.
    directions : ndarray, shape (P, P)
        These directions in columns, orthonormal.

    Returns
    -------
    ndarray, shape (P,), or None
        Unit vector over the prior widths, within the directions known to no better than a fifth of them; None
        where the size is known better, or the readings are not against targets.
    """
    grown = size_direction(structure) if structure.targets else None
    if grown is None:
        return None
    hardly = directions[:, variances > _HARDLY_KNOWN**2]
    within = hardly @ (hardly.T @ grown)
    length = float(np.linalg.norm(within))
    return within / length if length > _ALIKE else None


def without(space: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the directions of a space that are across another one.

    Parameters
    ----------
    space : ndarray, shape (P, k)
        Orthonormal directions in columns.
    direction : ndarray, shape (P,)
        Unit vector.

    Returns
    -------
    ndarray, shape (P, k - 1)
        Orthonormal; all k of them where the other one is not among them.
    """
    share = space.T @ direction
    if float(np.linalg.norm(share)) < _ALIKE:
        return space
    across = np.linalg.svd(share[None], full_matrices=True)[2][1:]
    return np.asarray(space @ across.T)


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
    message("open.base_of_cups"),
)
_BASE_OF_TARGETS = NotIdentifiable(BASE, message("open.base_of_targets"))


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
        Posterior with exactly these widths, internal units.
    jacobian : ndarray, shape (P, m)
        Whitened derivatives, per unit of each parameter.
    setting : Setting
    moved : ndarray of bool, shape (J,)
        Whether each joint moved.

    Returns
    -------
    tuple of NotIdentifiable
        By construction first, then what these configurations leave open.
    """
    built_in = _by_construction(structure, setting)
    return (*built_in, *undetermined_by_configurations(structure, covariance, jacobian, moved))


def undetermined_by_configurations(
    structure: Structure, covariance: FloatArray, jacobian: FloatArray, moved: BoolArray
) -> tuple[NotIdentifiable, ...]:
    """Name what these configurations leave open, others need not.

    Parameters
    ----------
    structure : Structure
        With the stated prior widths.
    covariance : ndarray, shape (P, P)
        Posterior with exactly these widths, internal units.
    jacobian : ndarray, shape (P, m)
        Whitened derivatives, per unit of each parameter.
    moved : ndarray of bool, shape (J,)
        Whether each joint moved.
    """
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
    entries = undetermined_by_construction(structure.effects, structure.names, setting)
    if structure.targets:
        return (_BASE_OF_TARGETS, *entries)
    return (_BASE_OF_CUPS, *entries) if structure.anchors else entries


def _by_data(
    structure: Structure, covariance: FloatArray, jacobian: FloatArray, moved: BoolArray
) -> list[NotIdentifiable]:
    widths = structure.prior_widths
    # In units of the priors, so that a border of one half means the same of millimetres and of springs.
    scaled = covariance / np.outer(widths, widths)
    eigenvalues, vectors = np.linalg.eigh(scaled)
    open_space = vectors[:, eigenvalues > UNDETERMINED**2]
    size = size_left_open(structure, eigenvalues, vectors)
    entries = [] if size is None else [_of_size(size * widths, jacobian, structure)]
    # The size is told by its own name, and not once more as a part of other combinations.
    open_space = open_space if size is None else without(open_space, size)
    if open_space.shape[1] == 0:
        return entries
    for direction in _sparse_basis(open_space):
        members = _members(direction * widths, jacobian, structure)
        entry = NotIdentifiable(members, _reason(members, structure, moved))
        # Directions that differ in no member are the same to a reader.
        if entry not in entries:
            entries.append(entry)
    return entries


def _of_size(direction: FloatArray, jacobian: FloatArray, structure: Structure) -> NotIdentifiable:
    return NotIdentifiable(_members(direction, jacobian, structure), message("open.size"))


def _sparse_basis(space: FloatArray) -> FloatArray:
    """Directions in rows, shape (k, P), each alone in moving its pivot parameter."""
    return np.asarray((space @ np.linalg.inv(space[_pivots(space)])).T)


def _pivots(space: FloatArray) -> list[int]:
    """Return one row for each column: every time the longest of what the rows before leave (pivoted QR)."""
    # Eigenvectors of equal size are mixed at will: pivots bring out pairs that are seen only together.
    left, pivots = space, list[int]()
    for _ in range(space.shape[1]):
        lengths = np.linalg.norm(left, axis=1)
        pivots.append(int(lengths.argmax()))
        direction = left[pivots[-1]] / lengths.max()
        left = left - np.outer(left @ direction, direction)
    return pivots


def _members(direction: FloatArray, jacobian: FloatArray, structure: Structure) -> tuple[str, ...]:
    """Parameters that take part: each alone would move the predictions, together they hardly do."""
    # Judged by what it moves, not by its share: units and widths of parameters differ by powers of ten.
    motion = np.linalg.norm(jacobian, axis=1) * np.abs(direction)
    by_width = np.abs(direction) / structure.prior_widths
    # A parameter that moves nothing at all is open by itself; its weight in the direction says so.
    taking_part = (motion > _TOGETHER * motion.max()) | ((motion < 1e-9) & (by_width > 0.5))
    if motion.max() < 1e-9:
        taking_part = by_width > 0.5
    return tuple(name for name, part in zip(structure.names, taking_part, strict=True) if part)


def _reason(members: tuple[str, ...], structure: Structure, moved: BoolArray) -> Message:
    still = [k + 1 for k in range(structure.robot.n_joints) if not moved[k]]
    joints_named = {int(name.split("*")[0].rsplit("_", 1)[1]) for name in members if _of_joint(name)}
    nests = sorted({name.split("_")[1] for name in members if name.startswith("nest_")})
    last = structure.robot.n_joints
    # From the particular to the general: the first sentence that holds is the one that helps.
    if {"length_offset", *(name for name in members if name.startswith("anchor_"))} & set(members):
        return message("open.anchor")
    if any(name.startswith("target_") for name in members):
        return message("open.target")
    if "scale" in members:
        return message("open.scale")
    if nests and {f"theta_{last}", f"d_{last}"} & set(members) and not set(still) & joints_named:
        return message(_TOOL_AND_LAST[len(nests) == 1, f"theta_{last}" in members], joint=last)
    if any("*" in name for name in members):
        return message("open.products")
    standing = sorted({joint for joint in still if joint in joints_named or joint + 1 in joints_named})
    if standing:
        return message("open.standing_joints", n=len(standing), joints=tuple(standing))
    if any(name.startswith("c_") for name in members) and len(members) > 1:
        return message("open.springs_alike")
    if len(members) == 1:
        return message("open.prior_holds_it")
    return message("open.combination")


def _of_joint(name: str) -> bool:
    quantity = name.split("*")[0].rsplit("_", 1)[0]
    return quantity in ("alpha", "a", "beta", "theta", "d", "c", "gain")
