r"""Every error signature at once, each a random function that is as large as the data ask for.

The signatures c have the columns X_c, each scaled to what is believed of it, and weights w_c ~ N(0, v_c I).
Past the parameters that are fitted they keep the products G = X^T X and b = X^T r. With D = diag(v_c) over
the variance of the noise, that noise profiled out of nu degrees of freedom, twice the log likelihood is

    -nu ln(R - b^T (G + D^-1)^-1 b) - ln det(I + D G).

It is raised one signature at a time: past those that are in, every other one is a single random function
whose most likely size is known in closed form. The one that gains most comes in, those that are in are sized
anew, and one that gains nothing any more goes out. What none needs stays at zero: the description is sparse
in signatures, not in parameters.

References
----------
D. A. Harville, J. American Statistical Association 72, 1977, 320-338 (REML).
M. E. Tipping, A. C. Faul, 9th Workshop on Artificial Intelligence and Statistics, 2003 (one at a time).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular

from truepose.diagnosis.screening.candidates import Pool
from truepose.diagnosis.screening.normal_equations import NormalEquations, Sums
from truepose.diagnosis.screening.selection import names_of
from truepose.diagnosis.screening.significance import Function, most_likely, most_likely_of
from truepose.domain.arrays import FloatArray, IntArray
from truepose.effects.causes import Candidate
from truepose.effects.signatures import signature_of

# Twice the log likelihood: what comes in must gain 4, as two standard deviations of one parameter would.
_LEAST_GAIN = 4.0
_SWEEPS = 2  # over the cells that are in, after each that comes in
_MOST_CELLS = 40
_HIGHEST_ORDER = 12.0  # of waves that are told apart from noise by a few readings
_ROUNDING = 1e-12  # of a column's square, added to it: a direction that only rounding supports
_NO_ROWS = np.zeros(0, dtype=np.int64)
_SEARCHED = frozenset({"jump", "settling"})  # over moments: one is right, their sum says nothing


@dataclass(frozen=True, slots=True)
class _Cell:
    """A place and a variable, with everything that may depend on the variable there."""

    candidates: tuple[Candidate, ...]  # with the widths that are believed
    rows: IntArray  # (k,) their columns in the pool


class CellSize(NamedTuple):
    """How large a cell is, past others."""

    gain: float  # of twice the log likelihood
    width: float  # over what is believed of it
    precision: float  # of its scaled parameters, times the variance of the noise


@dataclass(frozen=True, slots=True)
class CellProducts:
    """Products past what is fitted, of all K columns scaled to their widths; each cell is a run of them.

    Attributes
    ----------
    gram : ndarray, shape (K, K)
        Products among the columns.
    towards : ndarray, shape (K,)
        Their products with the residuals.
    sums : Sums
        Of the residuals.
    runs : tuple of ndarray of int
        Rows of each cell.
    """

    gram: FloatArray
    towards: FloatArray
    sums: Sums
    runs: tuple[IntArray, ...]

    def sizes(self, cells: Sequence[int], past: Mapping[int, CellSize]) -> dict[int, CellSize]:
        """Return the most likely sizes of cells, each alone past some others and no wider than its prior.

        With L L^T = G_hh + diag(precision) of the cells h that are held, a cell c keeps G_cc - A^T A and
        b_c - A^T t, where A = L^-1 G_hc and t = L^-1 b_h.

        Parameters
        ----------
        cells : sequence of int
            Those to be sized.
        past : mapping of int to CellSize
            Cells that are in, with their sizes; none of them is sized.

        Returns
        -------
        dict of int to CellSize
        """
        rows, precision = self._held(past)
        root = cholesky(self.gram[np.ix_(rows, rows)] + np.diag(precision), lower=True)
        taken = solve_triangular(root, self.towards[rows], lower=True)
        sums = self._left(float(taken @ taken))
        found = dict[int, CellSize]()
        # Cells of one number of columns together: most of the time went into asking for each by itself.
        for count in sorted({len(self.runs[cell]) for cell in cells}):
            alike = [cell for cell in cells if len(self.runs[cell]) == count]
            runs = np.stack([self.runs[cell] for cell in alike])
            absorbed = solve_triangular(root, self.gram[np.ix_(rows, runs.ravel())], lower=True)
            each = absorbed.T.reshape(len(alike), count, len(rows))
            grams = self.gram[runs[:, :, None], runs[:, None, :]] - each @ np.swapaxes(each, 1, 2)
            functions = most_likely_of(grams, self.towards[runs] - each @ taken, sums, widest=1.0)
            found |= {cell: _sized(one, sums) for cell, one in zip(alike, functions, strict=True)}
        return found

    def sized_anew(self, held: Mapping[int, CellSize]) -> dict[int, CellSize]:
        """Return the cells that are in, each sized past the others, but for those that gain too little.

        With S = (G_hh + D)^-1 of all that are in and m = S b_h, a cell c keeps past the others S_cc^-1 - D_c
        and S_cc^-1 m_c, and its D is exchanged by a change of S of its rank (M. A. Woodbury, 1950).

        Parameters
        ----------
        held : mapping of int to CellSize

        Returns
        -------
        dict of int to CellSize
        """
        rows, precision = self._held(held)
        inverse = cho_solve(cho_factor(self.gram[np.ix_(rows, rows)] + np.diag(precision)), np.eye(len(rows)))
        towards, now, first = self.towards[rows], dict(held), 0
        for cell, size in held.items():
            own = slice(first, first + len(self.runs[cell]))
            first = own.stop
            across, mean = inverse[:, own], inverse[own] @ towards
            past = np.linalg.inv(inverse[own, own])
            past = 0.5 * (past + past.T)
            # Where all cells together take everything, what is left past the others is what this one takes.
            least = self._left(float(towards @ inverse @ towards)).residual_square
            sums = replace(self.sums, residual_square=least + max(float(mean @ past @ mean), 0.0))
            gram = past - size.precision * np.eye(len(past))
            found = _sized(most_likely(gram, past @ mean, sums, widest=1.0), sums)
            # Half the gain of entry is enough to stay. With one threshold a cell at the limit would come in
            # and go out in turns until all rounds are used up.
            if found.gain >= _LEAST_GAIN / 2.0:
                now[cell] = found
                changed = found.precision - size.precision
                step = changed * np.linalg.inv(np.eye(len(past)) + changed * inverse[own, own])
            else:
                del now[cell]
                step = past
            inverse = inverse - across @ step @ across.T
        return now

    def _held(self, held: Mapping[int, CellSize]) -> tuple[IntArray, FloatArray]:
        """Return the rows of cells that are in, and the precision of each."""
        rows = np.concatenate([_NO_ROWS, *(self.runs[cell] for cell in held)])
        added = [np.full(len(self.runs[cell]), size.precision) for cell, size in held.items()]
        return rows, np.concatenate([np.zeros(0), *added])

    def _left(self, taken: float) -> Sums:
        """Return the sums of the residuals without what is taken of their square."""
        # Rounding may bring a sum of squares to 0 or below; its logarithm is taken next.
        return replace(self.sums, residual_square=max(self.sums.residual_square - taken, 1e-300))


def _sized(function: Function, sums: Sums) -> CellSize:
    """Return the size of a function; its precision is the noise's variance over the square of its width."""
    noise = (sums.residual_square - function.explained) / max(sums.degrees, 1.0)
    precision = noise / function.width**2 if function.width > 0.0 else np.inf
    return CellSize(function.gain, function.width, precision)


@dataclass(frozen=True, slots=True)
class SignatureComponents:
    """The cells that the data ask for.

    Attributes
    ----------
    candidates : tuple of Candidate
        Functions; their prior widths are as large as the data ask for.
    rows : ndarray of int, shape (k,)
        Columns in the pool, of all their parameters.
    """

    candidates: tuple[Candidate, ...]
    rows: IntArray

    def fitted(self, pool: Pool) -> NormalEquations:
        """Return the model of a pool with these cells fitted, to first order.

        Parameters
        ----------
        pool : Pool
            The one that they were described in, or a pool of the same candidates.

        Returns
        -------
        NormalEquations
        """
        widths = np.array([spec.prior_width for candidate in self.candidates for spec in candidate.specs])
        return pool.normal.beside(pool.products.rows(self.rows), widths, names_of(self.candidates))


def signatures_in_data(pool: Pool, picks: Sequence[Candidate] = ()) -> SignatureComponents:
    """Return the cells that the data ask for, those of the picks among them.

    Parameters
    ----------
    pool : Pool
        Of a model with the picks fitted.
    picks : sequence of Candidate
        Each is a cell by itself; its parameters are left out of the model first.

    Returns
    -------
    SignatureComponents
        Without candidates where no cell gains anything.
    """
    cells = _cells(pool, picks)
    if not cells:
        return SignatureComponents((), _NO_ROWS)
    widths = _sizes(_products(pool, cells, names_of(picks)))
    return SignatureComponents(
        tuple(
            candidate._replace(function=True).sized(width)
            for cell, width in widths.items()
            for candidate in cells[cell].candidates
        ),
        np.concatenate([_NO_ROWS, *(cells[cell].rows for cell in widths)]),
    )


def _cells(pool: Pool, picks: Sequence[Candidate]) -> list[_Cell]:
    """Gather what the pool proposes by place and variable, each pick by itself; a parameter counts once."""
    found: dict[tuple[str, str], list[tuple[Candidate, list[int]]]] = {}
    known = set(pool.normal.names)
    # Short candidates first: of two that share a parameter, the more special one keeps it.
    for index in sorted(range(len(pool.all)), key=lambda index: len(pool.all[index].specs)):
        candidate, cell = pool.all[index], signature_of(pool.all[index])
        high = cell.shape == "wave" and candidate.variant > _HIGHEST_ORDER
        if candidate.function or high or cell.shape in _SEARCHED:
            continue
        kept = [k for k, name in enumerate(candidate.names) if name not in known]
        known.update(candidate.names)
        if kept:
            believed = _believed(candidate, cell.shape == "wave")
            part = believed._replace(specs=tuple(believed.specs[k] for k in kept))
            rows = [pool.starts[index] + k for k in kept]
            found.setdefault((cell.where, cell.over), []).append((part, rows))
    own = [_Cell((pick,), pool.rows_of([pool.index_of(pick)])) for pick in picks]
    others = [
        _Cell(tuple(part for part, _ in parts), np.array([row for _, rows in parts for row in rows]))
        for parts in found.values()
    ]
    return own + others


def _believed(candidate: Candidate, wave: bool) -> Candidate:
    """Return a candidate with its widths: fast waves are smaller than slow ones, as in smooth curves."""
    if not wave or candidate.variant <= 1.0:
        return candidate
    specs = tuple(spec._replace(prior_width=spec.prior_width / candidate.variant) for spec in candidate.specs)
    return candidate._replace(specs=specs)


def _products(pool: Pool, cells: Sequence[_Cell], without: tuple[str, ...]) -> CellProducts:
    """Return the products of all cells past a model that is fitted without some parameters."""
    view = pool.view(without)
    rows = np.concatenate([cell.rows for cell in cells])
    widths = np.array([
        spec.prior_width for cell in cells for candidate in cell.candidates for spec in candidate.specs
    ])
    columns, absorbed = pool.products.columns[rows] * widths[:, None], view.absorbed[rows] * widths[:, None]
    ends = np.cumsum([len(cell.rows) for cell in cells]).tolist()
    runs = tuple(np.arange(end - len(cell.rows), end) for cell, end in zip(cells, ends, strict=True))
    # Cells that take all that readings left have precision 0. Of two with the same columns, only this keeps
    # the Cholesky factor of those that are in from failing.
    own = columns @ columns.T
    gram = own - absorbed @ absorbed.T + _ROUNDING * np.diag(np.diag(own))
    return CellProducts(gram, view.towards[rows] * widths, view.sums, runs)


def _sizes(products: CellProducts) -> dict[int, float]:
    """Return the width of every cell that the data ask for, over what is believed of it."""
    held: dict[int, CellSize] = {}
    for _ in range(_MOST_CELLS):
        others = [cell for cell in range(len(products.runs)) if cell not in held]
        sizes = products.sizes(others, held)
        best = max(sizes, key=lambda cell: sizes[cell].gain, default=None)
        if best is None or sizes[best].gain < _LEAST_GAIN:
            break
        held[best] = sizes[best]
        for _ in range(_SWEEPS):
            held = products.sized_anew(held)
    return {cell: size.width for cell, size in held.items()}
