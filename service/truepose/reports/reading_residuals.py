"""Each reading against the nominal robot and the identified model, in columns: what charts are drawn from.

Columns are numbered and named by keys; units are those that people read (mm, deg, °C, N·m, min).
"""

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import ContactReadings, LegReadings, Quantity, Readings, Stops
from truepose.domain.identification import Model
from truepose.identification.verdict.judge import Assessment, judge
from truepose.kinematics.frames import placement_translation

Name: TypeAlias = Literal[
    "joint", "torque", "number", "x", "y", "z", "reach", "time", "temperature", "attachment"
]
_MINUTE_S: Final = 60.0
_N_M: Final = 1000.0  # in N mm


@dataclass(frozen=True, slots=True)
class Variable:
    """What may explain an error, of each of n readings.

    Attributes
    ----------
    name : str
    unit : str
        Empty of what is counted.
    values : ndarray, shape (n,)
        NaN where it is not known.
    joint : int, optional
        Of an angle or a torque, from 1.
    """

    name: Name
    unit: str
    values: FloatArray
    joint: int | None = None


@dataclass(frozen=True, slots=True)
class ReadingResiduals:
    """The n readings of a result, with d components each: 3 of a position, 1 of a length.

    Attributes
    ----------
    robot, quantity : str
    config : ndarray of int, shape (n,)
    nest : ndarray of int, shape (n,)
        Of the tool, from 1.
    base_point : ndarray of int, shape (n,), or None
        Other ends of lengths.
    target : ndarray of int, shape (n,), or None
        Of contacts.
    before_mm, after_mm : ndarray, shape (n, d)
        Observed minus predicted, by the nominal robot and by the identified model [mm].
    expected_mm : ndarray, shape (n,)
        Root mean square of the size that noise, the arm's scatter and the uncertainty of the model let
        expect after identification [mm].
    variables : tuple of Variable
    """

    robot: str
    quantity: Quantity
    config: IntArray
    nest: IntArray
    base_point: IntArray | None
    target: IntArray | None
    before_mm: FloatArray
    after_mm: FloatArray
    expected_mm: FloatArray
    variables: tuple[Variable, ...]


def reading_residuals(model: Model, readings: Readings) -> ReadingResiduals:
    """Return how far each reading is off, before and after, and what its error may depend on.

    Parameters
    ----------
    model : Model
    readings : PointReadings, LegReadings or ContactReadings
        n >= 1 readings.

    Raises
    ------
    ConfigurationError
        The readings do not fit the model.
    """
    judged = judge(model, readings, model.repeatability_mm)
    components = judged.identified_mm.shape[1]
    return ReadingResiduals(
        robot=model.robot.name,
        quantity=readings.quantity,
        config=readings.stops.config,
        nest=readings.nest,
        base_point=readings.base_point if isinstance(readings, LegReadings) else None,
        target=readings.target if isinstance(readings, ContactReadings) else None,
        before_mm=judged.nominal_mm,
        after_mm=judged.identified_mm,
        expected_mm=np.sqrt(components * (judged.noise_variance + judged.variance)),
        variables=(*_of_arm(readings.stops), *_of_place(model, judged), *_of_session(readings.stops)),
    )


def _of_arm(stops: Stops) -> tuple[Variable, ...]:
    angles = np.rad2deg(stops.joints_rad).T
    joints = [Variable("joint", "deg", column, number) for number, column in enumerate(angles, 1)]
    if stops.torque_n_mm is None:
        return tuple(joints)
    torques = stops.torque_n_mm.T / _N_M
    return (*joints, *(Variable("torque", "N·m", column, number) for number, column in enumerate(torques, 1)))


def _of_place(model: Model, judged: Assessment) -> tuple[Variable, ...]:
    places = judged.position_mm
    reach = np.linalg.norm(places - placement_translation(model.base), axis=1)
    x, y, z = places.T
    told: dict[Name, FloatArray] = {"reach": reach, "x": x, "y": y, "z": z}
    return tuple(Variable(name, "mm", values) for name, values in told.items())


def _of_session(stops: Stops) -> tuple[Variable, ...]:
    told = [Variable("number", "", np.arange(1.0, len(stops) + 1.0))]
    if stops.time_s is not None:
        told.append(Variable("time", "min", (stops.time_s - np.nanmin(stops.time_s)) / _MINUTE_S))
    if stops.temperature_c is not None:
        told.append(Variable("temperature", "°C", stops.temperature_c))
    if stops.attachment is not None and np.ptp(stops.attachment) > 0:
        told.append(Variable("attachment", "", stops.attachment.astype(float)))
    return tuple(told)
