r"""Whether campaigns of one robot scatter as their readings say.

With m_c the parameters that the model of a fleet puts at campaign c and V_c their covariance, what a campaign
says otherwise is b_c - A_c m_c, of covariance A_c - A_c V_c A_c; so

    sum_c (b_c - A_c m_c)' A_c^+ (b_c - A_c m_c)    is expected to be    sum_c rank A_c - tr(A_c V_c)

over the campaigns of a robot. The ratio of the two is about 1; where it is larger, the robot comes back from
one campaign to the next less equal than its readings are precise (mountings, temperature, what no parameter
says), and its information is divided by it: by that of its middle campaign, which one campaign that is out of
order does not move, and by no less than that of the middle robot, which a few that age do not move.

References
----------
R. T. Birge, Phys. Rev. 40, 1932, 207-227.
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.fleet.mixed_model import Posterior

_RANK: Final = 1e-9  # of the largest eigenvalue
_FEWEST: Final = 10.0  # degrees of freedom: in fewer, a robot that ages would be its own measure


def birge_ratios(posterior: Posterior, given: FloatArray | None = None) -> FloatArray:
    """Return the ratio of variances of each robot, (R,); 1: none scatters more than its readings say.

    Parameters
    ----------
    posterior : Posterior
    given : ndarray, shape (R,), optional
        By which the information of each robot is divided already.
    """
    fleet = posterior.equations.fleet
    left = fleet.right - np.einsum("cpq,cq->cp", fleet.normal, posterior.fitted)
    squares, expected = (np.zeros(len(fleet.day)) for _ in range(2))
    for c, robot in enumerate(fleet.robot.tolist()):
        values, vectors = np.linalg.eigh(fleet.normal[c])
        seen = values > _RANK * values[-1]
        squares[c] = float(((vectors[:, seen].T @ left[c]) ** 2 / values[seen]).sum())
        put = posterior.put_at(c, robot)
        expected[c] = float(seen.sum()) - float(np.einsum("pq,pq->", fleet.normal[c], put))
    own = [fleet.robot == number for number in range(len(fleet.robots))]
    squares *= 1.0 if given is None else given[fleet.robot]
    whole = [squares[mine].sum() / max(expected[mine].sum(), 1.0) for mine in own]
    middle = [_of_the_middle_campaign(squares[mine], expected[mine]) for mine in own]
    return np.maximum(np.minimum(whole, middle), max(1.0, float(np.median(whole))))


def _of_the_middle_campaign(squares: FloatArray, expected: FloatArray) -> float:
    telling = expected >= _FEWEST
    return float(np.median(squares[telling] / expected[telling])) if telling.any() else 1.0
