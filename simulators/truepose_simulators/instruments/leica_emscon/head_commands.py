"""Commands that turn the head: start-up, pointing, searching, faces; and the directions of its beam."""

import functools
import math

import numpy as np

from truepose_drivers.leica_emscon import protocol
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import BeamError
from truepose_simulators.instruments.leica_emscon.coordinates import Quantity
from truepose_simulators.instruments.leica_emscon.parameters import SEARCH, wrong_parameter
from truepose_simulators.instruments.leica_emscon.settings import Handler, ServerSettings, Steps, Wait
from truepose_simulators.instruments.tracker import HOME_MM
from truepose_simulators.physics.rigid import FloatArray

_TURNING_SPEED_RAD_S = math.pi / 2.0


def direction(position_mm: FloatArray) -> tuple[float, float]:
    """Return horizontal angle (right-handed from x) and zenith angle of a point."""
    x, y, z = position_mm.tolist()
    return math.atan2(y, x), math.atan2(math.hypot(x, y), z)


def point_at(horizontal_rad: float, zenith_rad: float, distance_mm: float) -> FloatArray:
    """Return the point in that direction at that distance, shape (3,)."""
    radius = distance_mm * math.sin(zenith_rad)
    height = distance_mm * math.cos(zenith_rad)
    return np.array([radius * math.cos(horizontal_rad), radius * math.sin(horizontal_rad), height])


def turning_time_s(from_mm: FloatArray, to_mm: FloatArray) -> float:
    """Return how long the head turns from one aim to another."""
    across = float(np.linalg.norm(np.cross(from_mm, to_mm)))
    return math.atan2(across, float(from_mm @ to_mm)) / _TURNING_SPEED_RAD_S


_SEARCH_S = 1.0  # until a reflector near the aim is locked on and its distance set
_CHANGE_FACE_S = 4.0
_FARTHEST_MM = 320_000.0  # twice the range of an AT401: farther coordinates are in the wrong unit
# Status of everything that finds no reflector or lost it.
NO_REFLECTOR = protocol.ResultStatus.NO_DISTANCE_SET


class Aiming:
    """The head and its motors behind the protocol."""

    def __init__(self, cell: Cell, settings: ServerSettings) -> None:
        self._cell = cell
        self._tracker = cell.tracker
        self._settings = settings

    def handlers(self) -> dict[int, Handler]:
        """Return the commands served here; all but Initialize need an initialised tracker."""
        served: dict[int, Handler] = {
            protocol.Command.RELEASE_MOTORS: self._release,
            protocol.Command.PARK: self._release,
            protocol.Command.CHANGE_FACE: self._change_face,
            protocol.Command.GO_BIRD_BATH: self._go_home,
            protocol.Command.GO_BIRD_BATH2: self._go_home,
            protocol.Command.CHECK_BIRD_BATH: self._check_home,
            protocol.Command.GO_POSITION: self._go_position,
            protocol.Command.GO_POSITION_HVD: self._go_position,
            protocol.Command.POSITION_RELATIVE_HV: self._turn_by,
            protocol.Command.POINT_LASER: self._point_laser,
            protocol.Command.POINT_LASER_HVD: self._point_laser,
            protocol.Command.GO_NIVEL_POSITION: self._go_nivel_position,
            protocol.Command.GO_LAST_MEASURED_POINT: self._go_last_point,
            protocol.Command.FIND_REFLECTOR: self._find_reflector,
            protocol.Command.LOOK_FOR_TARGET: self._look_for_target,
            protocol.Command.GET_DIRECTION: self._get_direction,
        }
        guarded = {command: initialised_only(self._cell, handler) for command, handler in served.items()}
        return {**guarded, protocol.Command.INITIALIZE: self._initialise}

    def go_and_lock(self, aim_mm: FloatArray, radius_mm: float) -> Steps:
        """Turn to a point and search there; afterwards the tracker is locked on something or nothing."""
        yield Wait(turning_time_s(self._tracker.aim_mm, aim_mm))
        self._tracker.point(aim_mm)
        yield from self._search(math.atan2(radius_mm, float(np.linalg.norm(aim_mm))))

    def aim_of(self, values: protocol.Record) -> FloatArray | None:
        """Return the point that a request's coordinates mean, None when they mean none."""
        units = self._settings.units
        if "hz_angle" in values:
            aim = point_at(
                units.from_wire(Quantity.ANGLE, values.number("hz_angle")),
                units.from_wire(Quantity.ANGLE, values.number("vt_angle")),
                units.from_wire(Quantity.LENGTH, values.number("distance")),
            )
        else:
            aim = self._settings.view.from_wire(values.vector())
        return aim if aim.any() and (np.abs(aim) <= _FARTHEST_MM).all() else None

    @property
    def search_radius_mm(self) -> float:
        """How far from the aim a reflector is looked for."""
        return self._settings.kept(SEARCH).number("search_radius")

    def _search(self, radius_rad: float) -> Steps:
        if self._tracker.search(radius_rad):
            yield Wait(_SEARCH_S)
        else:
            yield Wait(self._settings.kept(SEARCH).integer("time_out") / 1000.0)

    def _initialise(self, request: protocol.Request) -> Steps:
        yield Wait(self._tracker.setup.initialise_s)
        self._tracker.initialise()
        yield protocol.Answer(request.command)
        yield protocol.StatusChange(protocol.SystemStatusChange.INITIALIZATION_STATUS_CHANGED)
        yield protocol.StatusChange(protocol.SystemStatusChange.MEAS_STATUS_READY)

    def _release(self, request: protocol.Request) -> Steps:
        self._tracker.point(self._tracker.aim_mm)
        yield protocol.Answer(request.command)
        yield protocol.StatusChange(protocol.SystemStatusChange.MEAS_STATUS_NOT_READY)

    def _go_home(self, request: protocol.Request) -> Steps:
        yield from self._turn_home()
        yield from self._locked(request.command)

    def _check_home(self, request: protocol.Request) -> Steps:
        """Home reflector against where it was at the start; a sound tracker finds it in its place."""
        yield from self._turn_home()
        if self._tracker.target is None:
            yield protocol.Answer(request.command, NO_REFLECTOR)
            return
        home = np.array(HOME_MM)
        horizontal, zenith = self._wire_angles(*direction(home))
        distance = self._settings.units.to_wire(Quantity.LENGTH, float(np.linalg.norm(home)))
        yield protocol.Answer(
            request.command,
            values=protocol.Record(
                initial_hz_angle=horizontal,
                initial_vt_angle=zenith,
                initial_distance=distance,
                hz_angle_diff=0.0,
                vt_angle_diff=0.0,
                distance_diff=0.0,
            ),
        )

    def _turn_home(self) -> Steps:
        yield Wait(turning_time_s(self._tracker.aim_mm, np.array(HOME_MM)) + _SEARCH_S)
        self._tracker.go_home()

    def _go_position(self, request: protocol.Request) -> Steps:
        aim = self.aim_of(request.values)
        if aim is None:
            yield protocol.Answer(request.command, wrong_parameter(1))
            return
        yield from self.go_and_lock(aim, self.search_radius_mm)
        yield from self._locked(request.command)

    def _go_last_point(self, request: protocol.Request) -> Steps:
        if self._tracker.last_measured_mm is None:
            yield protocol.Answer(request.command, protocol.ResultStatus.NO_LAST_MEASURED_POINT)
            return
        yield from self.go_and_lock(self._tracker.last_measured_mm, self.search_radius_mm)
        yield from self._locked(request.command)

    def _find_reflector(self, request: protocol.Request) -> Steps:
        """Search around the present direction; a failed search is reported as an error packet."""
        given = request.values.number("aprox_distance")
        distance_mm = self._settings.units.from_wire(Quantity.LENGTH, given)
        if not 0.0 < distance_mm <= _FARTHEST_MM:
            yield protocol.Answer(request.command, wrong_parameter(1))
            return
        yield from self._search(math.atan2(self.search_radius_mm, distance_mm))
        if self._tracker.target is None:
            yield protocol.ErrorReport(request.command, NO_REFLECTOR)
        else:
            yield from self._locked(request.command)

    def _look_for_target(self, request: protocol.Request) -> Steps:
        aim = self.aim_of(request.values)
        given = request.values.number("search_radius")
        radius_mm = self._settings.units.from_wire(Quantity.LENGTH, given)
        if aim is None or not radius_mm > 0.0:
            yield protocol.Answer(request.command, wrong_parameter(1 if aim is None else 4))
            return
        yield from self.go_and_lock(aim, radius_mm)
        if self._tracker.target is None:
            yield protocol.Answer(request.command, NO_REFLECTOR)
        else:
            yield protocol.Answer(request.command, values=self._direction())

    def _get_direction(self, request: protocol.Request) -> Steps:
        yield protocol.Answer(request.command, values=self._direction())

    def _turn_by(self, request: protocol.Request) -> Steps:
        from_wire = self._settings.units.from_wire
        turns = [from_wire(Quantity.ANGLE, request.values.number(name)) for name in ("hz_val", "vt_val")]
        horizontal, zenith = direction(self._tracker.aim_mm)
        if not 0.0 < zenith + turns[1] < math.pi:
            yield protocol.Answer(request.command, wrong_parameter(2))
            return
        distance = float(np.linalg.norm(self._tracker.aim_mm))
        aim = point_at(horizontal + turns[0], zenith + turns[1], distance)
        yield from self._point(request.command, aim)

    def _point_laser(self, request: protocol.Request) -> Steps:
        aim = self.aim_of(request.values)
        if aim is None:
            yield protocol.Answer(request.command, wrong_parameter(1))
        else:
            yield from self._point(request.command, aim)

    def _point(self, command: int, aim_mm: FloatArray) -> Steps:
        yield Wait(turning_time_s(self._tracker.aim_mm, aim_mm))
        self._tracker.point(aim_mm)
        yield protocol.Answer(command)

    def _go_nivel_position(self, request: protocol.Request) -> Steps:
        quarter = float(request.values.integer("nivel_position")) * math.pi / 2.0
        yield from self._point(request.command, point_at(quarter, math.pi / 2.0, 1000.0))

    def _change_face(self, request: protocol.Request) -> Steps:
        yield Wait(_CHANGE_FACE_S)
        self._tracker.face = 2 if self._tracker.face == 1 else 1
        try:
            self._tracker.locked_target()
        except BeamError:
            yield protocol.Answer(request.command, NO_REFLECTOR)
        else:
            yield protocol.Answer(request.command)
        face = self._tracker.face
        yield protocol.StatusChange(
            protocol.SystemStatusChange.IS_FACE_1 if face == 1 else protocol.SystemStatusChange.IS_FACE_2
        )

    def _locked(self, command: int) -> Steps:
        if self._tracker.target is None:
            yield protocol.Answer(command, NO_REFLECTOR)
            return
        yield protocol.Answer(command)
        yield protocol.StatusChange(protocol.SystemStatusChange.DISTANCE_SET)

    def _direction(self) -> protocol.Record:
        horizontal, zenith = self._wire_angles(*direction(self._tracker.aim_mm))
        return protocol.Record(hz_angle=horizontal, vt_angle=zenith)

    def _wire_angles(self, horizontal_rad: float, zenith_rad: float) -> tuple[float, float]:
        to_wire = self._settings.units.to_wire
        return to_wire(Quantity.ANGLE, horizontal_rad), to_wire(Quantity.ANGLE, zenith_rad)


def initialised_only(cell: Cell, handler: Handler) -> Handler:
    """Refuse a command while the tracker is not initialised."""

    @functools.wraps(handler)
    def guarded(request: protocol.Request) -> Steps:
        if not cell.tracker.initialised:
            return iter([protocol.Answer(request.command, protocol.ResultStatus.TRACKER_NOT_INITIALIZED)])
        return handler(request)

    return guarded
