"""Questions that only a simulated cell answers: its truth and its clock, JSON lines, one question each.

The clock has a driver too; a run that only lets time go by between two sessions needs none of it.
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
from truepose.domain.measurement.campaign import PointReadings, Stops

_LONGEST_LINE_BYTES: Final = 1 << 26  # an answer holds thousands of positions
_ANSWER_S: Final = 60.0


@dataclass(frozen=True, slots=True)
class TrueReadings:
    """Noise-free, scatter-free places of the nests at the rows of a campaign, and the nests themselves."""

    calibration_mm: FloatArray  # (n, 3) world frame
    validation_mm: FloatArray  # (m, 3) world frame
    tool_nests_mm: FloatArray  # (nests, 3) last frame
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
        """Return where the tool nests truly are, shape (nests, 3), last frame."""
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
