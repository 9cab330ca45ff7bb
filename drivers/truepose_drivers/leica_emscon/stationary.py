"""What a stationary result says: whether it is a point at all, and how sure the instrument is of it."""

import math

from truepose_drivers.api import Vector
from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.leica_emscon.protocol import Record
from truepose_drivers.leica_emscon.protocol.settings import MeasMode


def require_stationary_point(values: Record) -> None:
    """Raise RemoteProtocolError for a result of another mode, or one that is no point."""
    if values.integer("meas_mode") != MeasMode.STATIONARY or values.integer("is_try_mode"):
        raise RemoteProtocolError("the tracker measured in another mode than asked for: initialise it")
    point, deviations = values.vector(), values.vector("std1", "std2", "std3")
    if not all(map(math.isfinite, point)):
        raise RemoteProtocolError(f"the tracker measured {point}: that is no point")
    if any(deviation < 0.0 for deviation in (*deviations, values.number("std_total"))):
        raise RemoteProtocolError(f"the tracker states standard deviations of {deviations} mm: connect again")


def stated_covariance(values: Record) -> tuple[Vector, Vector, Vector] | None:
    """Return the a-priori covariance, from the accuracy model; None where the server states no such thing."""
    u1, u2, u3 = values.vector("apriori_std1", "apriori_std2", "apriori_std3")
    if not all(math.isfinite(u) and u > 0.0 for u in (u1, u2, u3)):
        return None
    mixed = ("apriori_covar12", "apriori_covar13", "apriori_covar23")
    c12, c13, c23 = values.vector(*mixed) if mixed[0] in values else (0.0, 0.0, 0.0)
    return (u1 * u1, c12, c13), (c12, u2 * u2, c23), (c13, c23, u3 * u3)  # ** would raise where * is inf
