"""Tables of a campaign as CSV text.

Digits: positions and lengths carry 1e-5 mm, a fiftieth of the best length instrument's noise (0.0005 mm);
angles 1e-9 deg, which moves the end of a 3 m arm by 5e-8 mm; torques 1e-6 N*m as robots report them.
Uncertainties carry eight significant digits, because a weight is relative. What was read from a file of
at most so many digits therefore comes back equal, and a second round trip changes nothing.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from truepose.domain.campaign import (
    CupReadings,
    CupSetups,
    FixedNestReadings,
    FixtureLengths,
    LegReadings,
    PointReadings,
    Stops,
)
from truepose.exchange.tables.points import COVARIANCE, POSITION, QUATERNION, UPPER_TRIANGLE
from truepose.exchange.tables.stops import NO_REPEAT, direction_names, joint_names, torque_names

_ANGLE, _POSITION, _UNCERTAINTY, _COVARIANCE, _WHOLE = ".9f", ".5f", ".8g", ".16e", "d"
_TIME, _TEMPERATURE, _TORQUE, _QUATERNION = ".4f", ".4f", ".6f", ".15f"
_N_M_PER_N_MM = 1e-3
Cells = dict[str, list[str]]


def table_text(columns: Mapping[str, Sequence[str]]) -> str:
    """Return CSV text of columns of equal length, in their order."""
    rows = zip(*columns.values(), strict=True)
    return "\n".join([",".join(columns), *map(",".join, rows), ""])


def point_text(readings: PointReadings) -> str:
    """Return a `calibration` or `validation` table."""
    return table_text({
        **_stop_cells(readings.stops),
        "nest": _cells(readings.nest, _WHOLE),
        **_position_cells(readings.position_mm),
        "u_mm": _cells(readings.standard_uncertainty_mm, _UNCERTAINTY),
        **_orientation_cells(readings),
        **_covariance_cells(readings.covariance_mm2),
    })


def reference_text(readings: FixedNestReadings) -> str:
    """Return a `reference` table."""
    return table_text({
        "time_s": _cells(readings.time_s, _TIME),
        "fixed_nest": _cells(readings.fixed_nest, _WHOLE),
        **_position_cells(readings.position_mm),
        "u_mm": _cells(readings.standard_uncertainty_mm, _UNCERTAINTY),
    })


def leg_text(legs: LegReadings) -> str:
    """Return a `legs` or `validation_legs` table."""
    initialisation = legs.initialisation
    return table_text({
        "placement": _cells(legs.placement, _WHOLE),
        **_stop_cells(legs.stops),
        **({} if initialisation is None else {"init": _cells(initialisation, _WHOLE)}),
        "base_point": _cells(legs.base_point, _WHOLE),
        "tool_point": _cells(legs.nest, _WHOLE),
        "length_mm": _cells(legs.length_mm, _POSITION),
        "u_mm": _cells(legs.standard_uncertainty_mm, _UNCERTAINTY),
    })


def fixture_text(fixture: FixtureLengths) -> str:
    """Return a `fixture` table."""
    return table_text({
        "placement": _cells(fixture.placement, _WHOLE),
        "kind": ["base" if placement else "tool" for placement in fixture.placement],
        "point_a": _cells(fixture.point_a, _WHOLE),
        "point_b": _cells(fixture.point_b, _WHOLE),
        "length_mm": _cells(fixture.length_mm, _POSITION),
        "u_mm": _cells(fixture.standard_uncertainty_mm, _UNCERTAINTY),
    })


def setup_text(setup: CupSetups) -> str:
    """Return a `setup` table."""
    names = joint_names(setup.joints_rad.shape[1])
    return table_text({
        "placement": _cells(setup.placement, _WHOLE),
        "base_point": _cells(setup.base_point, _WHOLE),
        **_block(names, np.degrees(setup.joints_rad), _ANGLE),
    })


def cup_text(cups: CupReadings) -> str:
    """Return a `cups` table."""
    return table_text({
        "placement": _cells(cups.placement, _WHOLE),
        "base_point": _cells(cups.base_point, _WHOLE),
        **_position_cells(cups.position_mm),
        "u_mm": _cells(cups.standard_uncertainty_mm, _UNCERTAINTY),
    })


def prediction_text(
    config: npt.NDArray[np.int64],
    nest: npt.NDArray[np.int64],
    position_mm: npt.NDArray[np.float64],
    standard_uncertainty_mm: npt.NDArray[np.float64],
) -> str:
    """Return the table `config, nest, x_mm, y_mm, z_mm, u_mm` of n predicted points."""
    return table_text({
        "config": _cells(config, _WHOLE),
        "nest": _cells(nest, _WHOLE),
        **_position_cells(position_mm),
        "u_mm": _cells(standard_uncertainty_mm, _POSITION),
    })


def _stop_cells(stops: Stops) -> Cells:
    n_joints = stops.joints_rad.shape[1]
    cells = {
        "config": _cells(stops.config, _WHOLE),
        **_block(joint_names(n_joints), np.degrees(stops.joints_rad), _ANGLE),
    }
    if stops.direction is not None:
        cells |= _block(direction_names(n_joints), stops.direction, _WHOLE)
    if stops.torque_n_mm is not None:
        cells |= _block(torque_names(n_joints), stops.torque_n_mm * _N_M_PER_N_MM, _TORQUE)
    optional: list[tuple[str, npt.NDArray[np.generic] | None, str]] = [
        ("time_s", stops.time_s, _TIME),
        ("temperature_C", stops.temperature_c, _TEMPERATURE),
        ("attachment", stops.attachment, _WHOLE),
        ("group", stops.group, _WHOLE),
    ]
    cells |= {name: _cells(values, form) for name, values, form in optional if values is not None}
    if stops.repeat_of is not None:
        cells["repeat_of"] = ["" if number == NO_REPEAT else str(number) for number in stops.repeat_of]
    return cells


def _position_cells(position_mm: npt.NDArray[np.float64]) -> Cells:
    return _block(POSITION, position_mm, _POSITION)


def _orientation_cells(readings: PointReadings) -> Cells:
    cells = {} if readings.quaternion is None else _block(QUATERNION, readings.quaternion, _QUATERNION)
    if readings.rotation_uncertainty_rad is not None:
        cells["u_rot_deg"] = _cells(np.degrees(readings.rotation_uncertainty_rad), _UNCERTAINTY)
    return cells


def _covariance_cells(covariance_mm2: npt.NDArray[np.float64] | None) -> Cells:
    """Return the upper triangle with all digits: rounding must not cost it its definiteness."""
    if covariance_mm2 is None:
        return {}
    return _block(COVARIANCE, covariance_mm2[:, *UPPER_TRIANGLE], _COVARIANCE)


def _block(names: Iterable[str], values: npt.NDArray[np.generic], form: str) -> Cells:
    return {name: _cells(column, form) for name, column in zip(names, values.T, strict=True)}


def _cells(values: npt.NDArray[np.generic], form: str) -> list[str]:
    """Format a column; NaN, an unknown value, becomes an empty cell."""
    return ["" if value != value else format(value, form) for value in values.tolist()]
