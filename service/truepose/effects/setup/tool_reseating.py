r"""Tool reseating: the tool sits a little differently after each mounting (tool changer, dirt).

The seats of all mountings together are one effect: draws about a mean that the arm and the certificate of the
tool define. Shift and turn are about the flange frame's origin, along its axes. The draws x_m of M occasions
scatter about an unknown mean with deviation s_g in the components of group g. They are known as a fit left
them: mean m and covariance C, under a prior N(0, W) that is taken out again, which leaves the information A =
C^-1 - W^-1, b = C^-1 m. The evidence for the deviations is then

    log p(s) = (b^T (A + S^-1)^-1 b - log det(I + S A)) / 2,   S = diag(s_g^2) + (a wide common mean)

Its maximum is the estimate, the root mean square distance from there under exp(log p) is its standard
uncertainty: few occasions leave a wide one, as they should. A coarse grid finds where the evidence is, a fine
one weighs it there.

Source: D. A. Harville, J. American Statistical Association 72, 1977, 320-338 (REML).
"""

from itertools import product

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.diagnosis import Detail
from truepose.domain.singular_covariance import inverse
from truepose.effects.causes import Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.motions import COMPONENTS, Widths, motion_specs, split_motion
from truepose.effects.ports import Need, ParameterSpec, Rows, Setting, Term, motion_port
from truepose.messages.message import Text, message

_COARSE, _FINE = 13, 15  # steps of the two grids
_FINEST, _WIDEST = 1e-2, 10.0  # of the prior's width: what the coarse grid spans
_NEGLIGIBLE = 6.0  # below the largest log evidence: 1/400 of it


def deviations(
    mean: FloatArray, covariance: FloatArray, widths: FloatArray, groups: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Estimate the deviation of each group of components, by the evidence of the module's head.

    Parameters
    ----------
    mean : ndarray, shape (M, d)
        Estimates of the draws of M occasions, d components each.
    covariance : ndarray, shape (M d, M d)
        Of these estimates, occasions first.
    widths : ndarray, shape (d,)
        Of the prior, about 0, under which they were estimated; the same within a group.
    groups : ndarray of int, shape (d,)
        Group 0, 1, .. of each component.

    Returns
    -------
    deviation, standard_uncertainty : ndarray, shape (G,)
        In the units of the groups' components.
    """
    occasions, components = mean.shape
    scale = np.tile(widths, occasions)
    precision = inverse(covariance / np.outer(scale, scale))
    vector = precision @ (mean.ravel() / scale)
    # Rounding takes a little more of the prior out than it put in, where the data see nothing.
    information = _positive(precision - np.eye(len(scale)))
    # Where the seats lie on average is what arm and certificate of the tool define: it says nothing of how
    # far they scatter, and a wide common mean takes it out of the evidence.
    common = np.kron(np.full((occasions, occasions), _WIDEST**2), np.eye(components))

    def evidence(deviation: FloatArray) -> float:
        return _evidence(np.tile(deviation[groups] ** 2, occasions), common, information, vector)

    n_groups = int(groups.max()) + 1
    # Even in the logarithm: nobody knows of what order the deviations are.
    coarse = np.array(list(product(np.geomspace(_FINEST, _WIDEST, _COARSE), repeat=n_groups)))
    level = np.array([evidence(deviation) for deviation in coarse])
    fine = _around(coarse[level > level.max() - _NEGLIGIBLE])
    level = np.array([evidence(deviation) for deviation in fine])
    best, share = fine[level.argmax()], np.exp(level - level.max())
    # About the best and not about the mean: with few occasions the evidence leans towards wide deviations.
    spread = np.sqrt(share @ (fine - best) ** 2 / share.sum())
    unit = np.array([widths[groups == group][0] for group in range(n_groups)])
    return best * unit, spread * unit


def _around(chosen: FloatArray) -> FloatArray:
    """Return an even grid over the box of the chosen deviations and one coarse step beyond, shape (m, G)."""
    step = (_WIDEST / _FINEST) ** (1.0 / (_COARSE - 1))
    low, high = chosen.min(axis=0) / step, chosen.max(axis=0) * step
    # A box that reaches the finest step reaches zero too: whether seats differ at all is the question.
    low = np.where(low < _FINEST, 0.0, low)
    axes = [np.linspace(a, b, _FINE) for a, b in zip(low, high, strict=True)]
    return np.array(list(product(*axes)))


def _positive(matrix: FloatArray) -> FloatArray:
    """Return a symmetric matrix with its negative eigenvalues set to 0."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def _evidence(variance: FloatArray, common: FloatArray, information: FloatArray, vector: FloatArray) -> float:
    """Return log p(s) but for a constant: (b^T S (1 + A S)^-1 b - log det(1 + A S)) / 2.

    (A + S^-1)^-1 = S (1 + A S)^-1, which holds for deviations of zero as well.

    Parameters
    ----------
    variance : ndarray, shape (M d,)
        s^2 of each component, in units of the prior's.
    common : ndarray, shape (M d, M d)
        Covariance of the common mean.
    information : ndarray, shape (M d, M d)
    vector : ndarray, shape (M d,)
    """
    spread = np.diag(variance) + common
    loaded = np.eye(len(variance)) + information @ spread
    explained = vector @ spread @ np.linalg.solve(loaded, vector)
    return 0.5 * float(explained - np.linalg.slogdet(loaded)[1])


NAME = "tool_reseating"
_WIDTHS = Widths(0.15, 1.5e-3)  # five times what a good tool changer repeats to
_SCALE = np.repeat([_WIDTHS.shift, _WIDTHS.turn], 3)
_SHIFTS_AND_TURNS = np.repeat([0, 1], 3)


class ToolReseating:
    """Six components per mounting."""

    name = NAME
    needs: frozenset[Need] = frozenset({"attachment"})
    signature = Signature("tool", "mounting", "group", "standard deviation between mountings", drawn="level")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the seats of all mountings."""
        # One mounting is where the tool sits: the arm's last parameters and the nests take it.
        return _specs(setting.attachments) if len(setting.attachments) > 1 else ()

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move the tool of that mounting, weight 1; one that was never seen sits as it does on average."""
        split = [split_motion(name) for name in names]
        here = {prefix: _mounted(rows, prefix) for prefix, _ in split}
        tool = rows.robot.n_joints
        return [
            Term(k, motion_port(tool, component), here[prefix]) for k, (prefix, component) in enumerate(split)
        ]

    def unseen(self, scene: Scene) -> Text | None:
        """Need several mountings."""
        if len(scene.setting.attachments) < 2:
            return message("unseen.one_mounting")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose the seats of all mountings together."""
        specs = self.specs(scene.setting)
        if not specs or specs[0].name in scene.present:
            return ()
        return (Candidate(NAME, "tool", specs),)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how far apart the seats are."""
        seats, covariance = _by_mounting(fitted)
        (shift, turn), (shift_u, turn_u) = deviations(seats, covariance, _SCALE, _SHIFTS_AND_TURNS)
        turn_deg, turn_u_deg = float(np.rad2deg(turn)), float(np.rad2deg(turn_u))
        sentence = message(
            "causes.tool_reseating", mountings=len(seats), shift_mm=float(shift), turn_deg=turn_deg
        )
        details = (
            Detail("rotation", turn_deg, "deg", turn_u_deg),
            Detail("mountings", float(len(seats)), "1", 0.0),
        )
        return Description(subject, float(shift), "mm", float(shift_u), sentence, details)


def _specs(attachments: tuple[int, ...]) -> tuple[ParameterSpec, ...]:
    return tuple(spec for number in attachments for spec in motion_specs(f"seat_{number}", _WIDTHS))


def _mounted(rows: Rows, prefix: str) -> FloatArray:
    attachment = rows.stops.attachment
    if attachment is None:
        return np.zeros(len(rows.stops))
    return np.asarray(attachment == int(prefix.split("_")[1]), dtype=float)


def _by_mounting(fitted: FittedCause) -> tuple[FloatArray, FloatArray]:
    """Return seats (M, 6) [mm, rad] and their covariance (6 M, 6 M), mounting by mounting."""
    split = [split_motion(name) for name in fitted.names]
    mountings = sorted({prefix for prefix, _ in split})
    # Whatever order the parameters were fitted in: `deviations` takes occasions first, components within
    # them.
    order = [split.index((prefix, component)) for prefix in mountings for component in range(len(COMPONENTS))]
    return fitted.values[order].reshape(-1, len(COMPONENTS)), fitted.covariance[np.ix_(order, order)]
