"""A camera's part of a session: it stands where it is said to, and tells the artefact's pose at each stop.

Its frame is the world of its readings: nothing but the arm is measured, and the arm's base is found in that
frame. Where it is said to stand only has to be good enough to tell another artefact, or another stop.
"""

import math
from collections.abc import Callable
from typing import Final, cast

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell import Camera
from truepose.domain.ledger import EntryKind
from truepose.domain.session import (
    PlannedStop,
    PointTaken,
    Registration,
    SessionPlan,
    Vector,
    stop_id,
)
from truepose.kinematics.frames import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    vector_from_rotation,
)
from truepose.messages.message import Text, message
from truepose.sessions.engine.identity_check import reported_serial_number
from truepose.sessions.engine.ledger import Logbook
from truepose.sessions.engine.nominal_arm import as_vector, nest_centre, nominal_chain
from truepose.sessions.errors import AttentionNeededError, PlanRefusedError, ReadingRejectedError
from truepose.sessions.tracker import steps as steps
from truepose.sessions.tracker.cell import AtRest, SessionCell
from truepose.sessions.tracker.registration import to_world
from truepose.sessions.tracker.state import TrackerSituation
from truepose.sessions.tracker.steps import StepKind
from truepose.sessions.tracker.tracking import TrackerIdentityCheck
from truepose_drivers.api import FullPoseTracker, PoseReading

_STANDS_WITHIN_MM: Final = 50.0  # of where a tape measure puts the camera, and the arm its tool
_TURNED_WITHIN_RAD: Final = 0.1  # likewise
_FITS_WITHIN_MM: Final = 0.5  # ten times what markers err by
_UNIT: Final = 1e-3  # by which a quaternion may be off, as codecs round it


class Poses:
    """Does the operations of a camera."""

    def __init__(
        self,
        plan: SessionPlan,
        cell: SessionCell,
        logbook: Logbook[TrackerSituation],
        identities: TrackerIdentityCheck,
    ) -> None:
        if cell.camera is None:
            raise PlanRefusedError(message("session.camera.none"))
        self._plan, self._cell, self._camera = plan, cell, cell.camera
        self._device = cast(FullPoseTracker, cell.tracker)
        self._logbook = logbook
        self._identities = identities
        self._centre_mm = nest_centre(cell.nests, cell.camera.nest)

    def begin_step(self) -> None:
        """Forget what belongs to an earlier step: nothing does."""

    def in_world(self, point_mm: Vector) -> None:
        """Return nothing: a camera shows no single reflector."""

    async def conditions(self) -> list[Text]:
        """Return what the camera says that it measures with, where it says something."""
        return [*filter(None, [self._device.settings])]

    async def perform(self, operation: steps.Operation, at_rest: Callable[[], AtRest]) -> None:
        """Do one operation; raises what the camera and the checks raise."""
        match operation:
            case steps.PlaceCamera():
                await self._place()
            case steps.MeasurePose(stop):
                await self._measure(stop, at_rest())
            case _:
                raise PlanRefusedError(message("session.cannot.camera", operation=str(operation)))

    async def _place(self) -> None:
        serial = reported_serial_number((await self._identities.meet("tracker", self._device)).serial)
        placed = stated_place(self._camera, serial)
        await self._logbook.write(EntryKind.COMPUTED, StepKind.REGISTER, registration=placed)

    async def _measure(self, stop: PlannedStop, here: AtRest) -> None:
        reading = await self._device.measure_pose(duration_s=self._plan.measure_s)
        # asked after the reading: one that was exchanged meanwhile behind the same address is seen
        serial = reported_serial_number((await self._identities.meet("tracker", self._device)).serial)
        turn = _turn(reading)
        seen_mm = turn @ self._centre_mm + np.array(reading.position_mm)
        world_mm, world_turn = to_world(self._registration, seen_mm), self._registration.rotation @ turn
        self._check(stop, reading, world_mm, world_turn)
        point = self._record(stop, reading, here, seen_mm, world_mm, world_turn, serial)
        await self._logbook.write(EntryKind.MEASURED, stop_id(stop.config), point=point, time_s=point.time_s)

    @property
    def _registration(self) -> Registration:
        found = self._logbook.situation.registration
        if found is None:
            raise AttentionNeededError(message("session.camera.no_place"))
        return found

    def _check(
        self, stop: PlannedStop, reading: PoseReading, world_mm: FloatArray, world_turn: FloatArray
    ) -> None:
        """Raise ReadingRejectedError for another artefact than the expected one, and for one in motion."""
        expected = nominal_chain(self._cell.robot, self._cell.base, np.array([stop.joints_rad]))
        off_mm = float(np.linalg.norm(world_mm - expected.points(self._centre_mm)[0]))
        off_rad = float(np.linalg.norm(vector_from_rotation(world_turn @ expected.end_rotation[0].T)))
        # Wide, since nothing has been measured of where the camera stands: it need only tell another
        # artefact, or another stop.
        if off_mm > _STANDS_WITHIN_MM or off_rad > _TURNED_WITHIN_RAD:
            raise ReadingRejectedError(
                message(
                    "session.artefact.elsewhere",
                    off_mm=off_mm,
                    off_deg=math.degrees(off_rad),
                    limit_mm=_STANDS_WITHIN_MM,
                    limit_deg=math.degrees(_TURNED_WITHIN_RAD),
                )
            )
        if reading.rms_mm > _FITS_WITHIN_MM:  # NaN where the instrument judges that by itself
            raise ReadingRejectedError(
                message("session.artefact.hidden", off_mm=reading.rms_mm, limit_mm=_FITS_WITHIN_MM)
            )
        scatter_mm = float(np.linalg.norm(reading.position_deviation_mm))
        if scatter_mm > self._plan.rms_limit_mm:  # NaN of a single frame is none
            raise ReadingRejectedError(
                message("session.frames.scatter", off_mm=scatter_mm, limit_mm=self._plan.rms_limit_mm)
            )

    def _record(
        self,
        stop: PlannedStop,
        reading: PoseReading,
        here: AtRest,
        seen_mm: FloatArray,
        world_mm: FloatArray,
        world_turn: FloatArray,
        serial: str,
    ) -> PointTaken:
        w, *xyz = quaternion_from_rotation(world_turn).tolist()
        return PointTaken(
            config=stop.config,
            nest=self._camera.nest,
            commanded_rad=stop.joints_rad,
            reported_rad=here.joints.joints_rad,
            direction=here.direction,
            time_s=reading.time_s,
            temperature_c=math.nan,
            attachment=self._cell.attachment,
            position_tracker_mm=as_vector(seen_mm),
            position_world_mm=as_vector(world_mm),
            # The camera states no uncertainty of a reading; the cell file does.
            standard_uncertainty_mm=self._camera.position_u_mm,
            rms_mm=reading.rms_mm,
            samples=reading.frames,
            repeat_of=stop.repeat_of,
            instrument_serial=serial,
            group=stop.group,
            quaternion=(w, *xyz),
            rotation_uncertainty_rad=self._camera.rotation_u_rad,
        )


def _turn(reading: PoseReading) -> FloatArray:
    """Return the rotation that a reading states; raises ReadingRejectedError for what is no pose."""
    quaternion = np.array(reading.quaternion)
    stated = (*reading.quaternion, *reading.position_mm, reading.time_s)
    length = float(np.linalg.norm(quaternion))
    if not all(map(math.isfinite, stated)) or abs(length - 1.0) > _UNIT:
        raise ReadingRejectedError(message("session.camera.no_pose"))
    # Codecs round it, so that its length is 1 to a thousandth; the rotation has to be one exactly.
    return rotation_from_quaternion(quaternion / length)


def stated_place(camera: Camera, serial: str = "") -> Registration:
    """Return where a camera stands by its cell file."""
    return Registration(
        rotation=_stated_turn(camera),
        translation_mm=np.array(camera.position_mm),
        covariance=np.zeros((6, 6)),  # the world of the readings is what it is said to be
        rms_mm=math.nan,  # nothing was measured
        two_face_mm=None,
        instrument_serial=serial,
    )


def _stated_turn(camera: Camera) -> FloatArray:
    """Return a camera's axes in the world, shape (3, 3): one that looks does so along -z, and x is level."""
    sight = np.array(camera.looks_at_mm) - np.array(camera.position_mm)
    # Such an instrument states its readings in a levelled frame, wherever its head looks.
    if camera.upright:
        z = np.array([0.0, 0.0, 1.0])
        x = np.array([sight[0], sight[1], 0.0])
    else:
        z = -sight / np.linalg.norm(sight)
        x = np.cross([0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=-1)
