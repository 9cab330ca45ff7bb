"""What was done in a cell, kept in a file, so that a cell that is started anew stands where it stood.

One JSON object a line: first which cell it is, then every motion of the robot, deed of the hands, mounting of
the tool and planted effect with its cell time. What is true in a cell follows from its seed and from what was
done when; so doing the same again leads to the same cups, zeros and stops. Only what readings drew from the
cell's own generator is not repeated: after tracker readings the scatter of later stops is another one.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from truepose_simulators.cell.robot import JointMotion, SpeedLimits
from truepose_simulators.cell.simulated_operator import Detail
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import JournalError, SimulatorError
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.scenarios.table import read_file

_FORMAT = 1


class Journal:
    """A file that gets a line for whatever was done; one that was cut off counts for nothing."""

    def __init__(self, path: Path, heading: Mapping[str, object]) -> None:
        """Open the journal of this cell; that of another cell is begun anew. Raises JournalError."""
        self._path = path
        self._heading = {"format": _FORMAT, **heading}
        try:
            self.entries = self._read()
            # What was cut off, or is of another cell, goes; the rest is written as it was.
            whole = b"".join(_line(entry) for entry in (self._heading, *self.entries))
            beside = path.with_name(f"{path.name}.new")
            beside.write_bytes(whole)
            beside.replace(path)
        except OSError as error:
            raise JournalError(f"{path}: the state of the cell cannot be saved ({error.strerror})") from error

    def add(self, **entry: object) -> None:
        """Write an entry; once this returns, it outlives the process."""
        with self._path.open("ab") as file:
            file.write(_line(entry))

    def _read(self) -> list[dict[str, Any]]:
        if not self._path.exists():
            return []
        lines = list(_documents(read_file(self._path)))
        return lines[1:] if lines[:1] == [self._heading] else []


class RememberedCell(Cell):
    """A cell that writes down what is done in it, and has done what its journal tells."""

    _journal: Journal | None = None

    async def remember(self, path: Path) -> None:
        """Do again what the journal at `path` tells, then go on with it; raises JournalError.

        The clock has to stand still meanwhile (pace 0); a motion that was under way is finished.
        """
        scenario = hashlib.sha256(repr((self.scenario, self.model)).encode()).hexdigest()
        journal = Journal(path, {"scenario": scenario, "seed": self.seed})
        for number, entry in enumerate(journal.entries, start=2):
            try:
                await self._do_again(entry)
            except (KeyError, TypeError, ValueError, SimulatorError) as error:
                raise JournalError(
                    f"{path}, line {number}: cannot be replayed ({error}); delete the file to start afresh"
                ) from error
        motion = self.robot.motion
        await self.clock.sleep(max(0.0, motion.start_s + motion.duration_s - self.clock.now_s))
        self._journal = journal

    def set_off(
        self, waypoints_rad: Sequence[FloatArray], limits: SpeedLimits, tool_mm: FloatArray
    ) -> JointMotion:
        """Begin to move along waypoints; raises TargetOutOfRangeError, and then nothing has moved."""
        motion = super().set_off(waypoints_rad, limits, tool_mm)
        self._note(
            did="move",
            waypoints_rad=[np.asarray(waypoint).tolist() for waypoint in waypoints_rad],
            limits=asdict(limits),
            tool_mm=np.asarray(tool_mm).tolist(),
        )
        return motion

    def halt_robot(self) -> None:
        """Stop the arm where it is now; without a motion under way that is nothing."""
        if self.robot_moves:
            self._note(did="halt")
        super().halt_robot()

    def plant_change(self, change: PlantedChange) -> None:
        """Plant a change; raises ScenarioError or NoEquilibriumError, and then nothing has changed."""
        super().plant_change(change)
        self._note(did="effect", change=asdict(change))

    def mount_tool_anew(self) -> None:
        """Take the tool off and put it on again."""
        super().mount_tool_anew()
        self._note(did="attach")

    def do(self, action: str, details: Mapping[str, Detail]) -> None:
        """Have the hands do one thing; raises HandsError."""
        self.hands.do(action, details)
        self._note(did="deed", action=action, details=dict(details))

    def _note(self, **entry: object) -> None:
        if self._journal is not None:
            self._journal.add(time_s=self.clock.now_s, **entry)

    async def _do_again(self, entry: Mapping[str, Any]) -> None:
        """Do at its time what an entry tells."""
        await self.clock.sleep(max(0.0, float(entry["time_s"]) - self.clock.now_s))
        match entry["did"]:
            case "move":
                waypoints = [np.array(waypoint, dtype=np.float64) for waypoint in entry["waypoints_rad"]]
                self.set_off(waypoints, SpeedLimits(**entry["limits"]), np.array(entry["tool_mm"]))
            case "halt":
                self.halt_robot()
            case "effect":
                self.plant_change(PlantedChange(**entry["change"]))
            case "attach":
                self.mount_tool_anew()
            case "deed":
                self.hands.do_again(entry["action"], entry["details"])
            case other:
                raise ValueError(other)


def _documents(data: bytes) -> Iterator[dict[str, Any]]:
    """Yield whole lines up to the first that is none."""
    for line in data.splitlines(keepends=True):
        try:
            document = json.loads(line) if line.endswith(b"\n") else None
        except ValueError:
            return
        if not isinstance(document, dict):
            return
        yield document


def _line(document: Mapping[str, object]) -> bytes:
    return json.dumps(document, allow_nan=False).encode() + b"\n"
