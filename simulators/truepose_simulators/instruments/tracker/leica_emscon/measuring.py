"""Stationary measurements as result packets."""

import numpy as np

from truepose_drivers.leica_emscon.protocol import PacketType, Record, Result
from truepose_drivers.leica_emscon.protocol.settings import MeasMode
from truepose_simulators.cell.air import HUMIDITY_PERCENT, PRESSURE_HPA
from truepose_simulators.instruments.tracker.device import PointMeasured, Tracker
from truepose_simulators.instruments.tracker.leica_emscon.settings import ServerSettings
from truepose_simulators.instruments.tracker.leica_emscon.units import Quantity
from truepose_simulators.physics.rigid import FloatArray


class Points:
    """The reflector locked on, as subject of a measurement."""

    def __init__(self, tracker: Tracker, settings: ServerSettings) -> None:
        self._tracker = tracker
        self._settings = settings

    def sight(self) -> FloatArray:
        """Return where it is now; raises BeamError."""
        return self._tracker.locked_target().position_mm

    def lose(self) -> None:
        """Let go of it."""
        self._tracker.release()

    def result(self, duration_s: float, before_mm: FloatArray, air: Record) -> Result:
        """Measure it, where it was at `before_mm` when that began; raises BeamError."""
        point = self._tracker.measure(duration_s, before_mm)
        self._tracker.last_measured_mm = point.position_mm
        return stationary_result(point, air, self._settings)

    def position(self, duration_s: float) -> FloatArray:
        """Return one quick reading of where it is; raises BeamError."""
        return self._tracker.measure(duration_s).position_mm


def stationary_result(point: PointMeasured, air: Record, settings: ServerSettings) -> Result:
    """Return the packet that the statistic mode asks for."""
    shown = settings.view.covariance_to_wire(point.position_mm, point.covariance_mm2)
    apriori = settings.view.covariance_to_wire(point.position_mm, point.apriori_covariance_mm2)
    members = Record(meas_mode=MeasMode.STATIONARY, is_try_mode=False, **air)
    members.update(coordinates(settings, point.position_mm))
    members.update(deviations("std", shown), **deviations("apriori_std", apriori))
    # The total is a length: the root of the sum of the variances in space, whatever the coordinates are.
    members["std_total"] = total(point.covariance_mm2, settings)
    members["apriori_std_total"] = total(point.apriori_covariance_mm2, settings)
    if not settings.extended_statistics:
        members.update(pointing_error1=0.0, pointing_error2=0.0, pointing_error3=0.0)
        return Result(PacketType.SINGLE_MEAS_RESULT, members)
    members.update(covariances("covar", shown), **covariances("apriori_covar", apriori))
    members.update(pointing_error_h=0.0, pointing_error_v=0.0, pointing_error_d=0.0)
    return Result(PacketType.SINGLE_MEAS_RESULT_2, members)


def coordinates(settings: ServerSettings, position_mm: FloatArray) -> Record:
    """Return val1 val2 val3 of a point of the instrument frame."""
    return Record(zip(("val1", "val2", "val3"), settings.view.to_wire(position_mm), strict=True))


def air_members(settings: ServerSettings, temperature_c: float) -> Record:
    """Return the air as the server states it with a result."""
    to_wire = settings.units.to_wire
    return Record(
        temperature=to_wire(Quantity.TEMPERATURE, temperature_c),
        pressure=to_wire(Quantity.PRESSURE, PRESSURE_HPA),
        humidity=HUMIDITY_PERCENT,
    )


def deviations(name: str, covariance: FloatArray) -> Record:
    """Return the standard deviations of three coordinates as members `name`1 to `name`3."""
    deviations = np.sqrt(np.diag(covariance)).tolist()
    return Record({f"{name}{number}": value for number, value in enumerate(deviations, start=1)})


def covariances(name: str, covariance: FloatArray) -> Record:
    """Return the covariances of three coordinates as members `name`12, `name`13, `name`23."""
    pairs = {"12": (0, 1), "13": (0, 2), "23": (1, 2)}
    return Record({f"{name}{key}": float(covariance[pair]) for key, pair in pairs.items()})


def total(covariance_mm2: FloatArray, settings: ServerSettings) -> float:
    """Return the root of the sum of the variances, in the user's unit."""
    return settings.units.to_wire(Quantity.LENGTH, float(np.sqrt(np.trace(covariance_mm2))))
