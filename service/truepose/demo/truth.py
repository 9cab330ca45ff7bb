"""Questions that only a simulated cell answers: its truth, also as a camera would read it, and its clock.

The clock has a driver too; a run that only lets time go by between two sessions needs none of it.

A camera's world is its own frame, put where the cell file says that it stands. Truth of the cell's world is
moved there, so that true errors are those of positions before the camera.
"""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from truepose.demo.errors import TruthUnknownError
from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.cell import Camera, Cell
from truepose.kinematics.frames import quaternion_from_rotation, rigid_alignment
from truepose.sessions.tracker.camera_measurement import stated_place

_LONGEST_LINE_BYTES: Final = 1 << 26  # an answer holds thousands of positions
_ANSWER_S: Final = 60.0


@dataclass(frozen=True, slots=True)
class TrueReadings:
    """Noise-free, scatter-free places of the nests at the rows of a campaign, and the nests themselves."""

    calibration_mm: FloatArray  # (n, 3) world frame
    validation_mm: FloatArray  # (m, 3) world frame
    tool_nests_mm: FloatArray  # (nests, 3) flange frame
    calibration_quaternion: FloatArray | None = None  # (n, 4) w first, world frame; None: no poses are read
    judged: PointReadings | None = None  # m rows that the validation is of; None: those of the campaign


class CellEndpoint:
    """An open connection to the truth endpoint or the clock of a cell."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader = reader
        self._writer = writer

    async def positions_mm(self, readings: PointReadings) -> FloatArray:
        """Return where the nests truly were at each reading, shape (n, 3), world frame."""
        stops = readings.stops
        request: dict[str, Any] = {"joints_rad": stops.joints_rad.tolist(), "nests": readings.nest.tolist()}
        if stops.time_s is not None:
            request["time_s"] = stops.time_s.tolist()
        return np.array((await self.ask("positions", **request))["positions_mm"], dtype=np.float64)

    async def every_nest_mm(self, stops: Stops) -> FloatArray:
        """Return where all nests truly were at each of n stops, shape (n, nests, 3), world frame."""
        request: dict[str, Any] = {"joints_rad": stops.joints_rad.tolist()}
        if stops.time_s is not None:
            request["time_s"] = stops.time_s.tolist()
        return np.array((await self.ask("positions", **request))["positions_mm"], dtype=np.float64)

    async def tool_nests_mm(self) -> FloatArray:
        """Return where the tool nests truly are, shape (nests, 3), flange frame."""
        return np.array((await self.ask("plant"))["tool_nests_mm"], dtype=np.float64)

    async def ask(self, operation: str, **request: Any) -> dict[str, Any]:
        """Put a question; raises TruthUnknownError with the cell's own sentence."""
        self._writer.write(json.dumps({"op": operation, **request}).encode() + b"\n")
        await self._writer.drain()
        line = await asyncio.wait_for(self._reader.readline(), _ANSWER_S)
        if not line:
            raise TruthUnknownError("The simulated cell closed the connection; see the service's log.")
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise TruthUnknownError(f"The simulated cell refused '{operation}': {answer['error']}")
        return answer


@contextlib.asynccontextmanager
async def cell_endpoint(host: str, port: int) -> AsyncIterator[CellEndpoint]:
    """Connect to an endpoint; raises TruthUnknownError where there is none or it falls silent."""
    try:
        reader, writer = await asyncio.open_connection(host, port, limit=_LONGEST_LINE_BYTES)
        try:
            yield CellEndpoint(reader, writer)
        finally:
            writer.close()
            with contextlib.suppress(ConnectionError):
                await writer.wait_closed()
    except (OSError, TimeoutError) as error:
        raise TruthUnknownError(f"The simulated cell does not answer at {host}:{port} ({error}).") from error


@dataclass(frozen=True, slots=True)
class ShownArtefact:
    """The camera, and the artefact's centre in the flange frame as the cell file has it."""

    camera: Camera
    centre_mm: FloatArray  # (3,)


def camera_artefact(cell: Cell) -> ShownArtefact | None:
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
