"""The truth of a cell whose camera reads poses: the same nests, in the frame of the camera's readings.

A camera's world is its own frame, put where the cell file says that it stands. Truth of the cell's world is
moved there, so that true errors are those of positions before the camera.
"""

from dataclasses import dataclass

import numpy as np

from truepose.demo.cell.truth import CellEndpoint, TrueReadings
from truepose.domain.arrays import FloatArray
from truepose.domain.cell.description import Camera, Cell
from truepose.domain.measurement.campaign import PointReadings, Stops
from truepose.kinematics.frames import quaternion_from_rotation, rigid_alignment
from truepose.sequencing.tracker.instruments.poses import stated_place


@dataclass(frozen=True, slots=True)
class ShownArtefact:
    """The camera, and the artefact's centre in the last frame as the cell file has it."""

    camera: Camera
    centre_mm: FloatArray  # (3,)


def shown_artefact(cell: Cell) -> ShownArtefact | None:
    """Return what the camera of a cell is shown; None in a cell whose tracker reads points."""
    camera = cell.camera
    if camera is None:
        return None
    return ShownArtefact(camera, np.array(cell.nests[camera.nest - 1].centre_mm))


async def true_poses(
    endpoint: CellEndpoint, calibration: PointReadings, validation: PointReadings, shown: ShownArtefact
) -> TrueReadings:
    """Return what the camera would tell without noise, and where every nest was at the validation's stops."""
    plant = await endpoint.ask("plant")
    moved = _IntoReadings(plant["camera"], shown.camera)
    seen_mm = moved(await endpoint.every_nest_mm(calibration.stops))
    turns, centres_mm = _poses(np.array(plant["camera"]["artefact_mm"]), seen_mm, shown.centre_mm)
    nests_mm = np.array(plant["tool_nests_mm"])
    judged = moved(await endpoint.every_nest_mm(validation.stops))
    return TrueReadings(
        calibration_mm=centres_mm,
        validation_mm=judged.reshape(-1, 3),
        tool_nests_mm=np.vstack([nests_mm, shown.centre_mm]),
        calibration_quaternion=quaternion_from_rotation(turns),
        judged=_every_nest(validation, len(nests_mm)),
    )


class _IntoReadings:
    """Moves true places from the cell's world into that of the readings."""

    def __init__(self, true: dict[str, list[float]], camera: Camera) -> None:
        self._rotation, self._origin_mm = np.array(true["rotation"]), np.array(true["translation_mm"])
        self._stated = stated_place(camera)

    def __call__(self, places_mm: FloatArray) -> FloatArray:
        """Return places (..., 3) as the camera has them in its world."""
        seen_mm = (places_mm - self._origin_mm) @ self._rotation
        return np.asarray(seen_mm @ self._stated.rotation.T + self._stated.translation_mm)


def _poses(
    defined_mm: FloatArray, places_mm: FloatArray, centre_mm: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return turns (n, 3, 3) and centres (n, 3) of the artefact as defined, from its nests (n, K, 3)."""
    each = [rigid_alignment(defined_mm, at) for at in places_mm]
    turns = np.array([turn for turn, _ in each])
    return turns, np.array([turn @ centre_mm + shift for turn, shift in each])


def _every_nest(readings: PointReadings, nests: int) -> PointReadings:
    """Return a row for each nest at each stop; what was read there is nobody's business."""
    stops: Stops = readings.stops.taken(np.repeat(np.arange(len(readings)), nests))
    unread = np.full((len(stops), 3), np.nan)
    return PointReadings(stops, np.tile(np.arange(1, nests + 1), len(readings)), unread, unread[:, 0])
