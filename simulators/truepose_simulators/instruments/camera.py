"""The camera as a device: the pose of the artefact, whose nests it sees, in its own frame.

It looks along its negative z axis. That the arm may hide the artefact is not modelled.
"""

import math
from dataclasses import dataclass

import numpy as np

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.kinds import TrackerBlinded
from truepose_simulators.instruments.accuracy import CameraSetup
from truepose_simulators.physics.rigid import (
    FloatArray,
    inverse,
    motion,
    move,
    register,
    rotation,
    to_quaternion,
)

_OF_THE_CAMERA = 0xCA  # its own chances: those of the other instruments stay as they are
# A rigid body keeps six of the nine errors of three nests, so that its nests err by less than each was read.
_KEPT = math.sqrt(6.0 / 9.0)
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class PoseSeen:
    """The artefact in one frame, camera frame."""

    quaternion: FloatArray  # (4,) w x y z
    position_mm: FloatArray  # (3,)
    rms_mm: float  # of the fit
    nests_outside: int  # of the measuring volume


class Camera:
    """Watches the artefact of a cell; knows no protocol."""

    def __init__(self, cell: Cell, setup: CameraSetup) -> None:
        """Stand somewhere near the stated place; raises ScenarioError for an artefact without three nests."""
        rng = np.random.default_rng([cell.seed, _OF_THE_CAMERA])
        nests_mm = np.array(cell.scenario.tool.nests_mm)
        if len(nests_mm) < 3:
            raise ScenarioError(f"[camera]: an artefact with {len(nests_mm)} nests has no pose: give three")
        self.setup = setup
        self.frame = _place(setup, rng)  # (4, 4) in the world
        self._cell = cell
        # (nests, 3) of the artefact by its definition, flange frame
        self.defined_mm = nests_mm + setup.artefact_mm / _KEPT * rng.standard_normal(nests_mm.shape)

    def see(self, frame: int) -> PoseSeen | None:
        """Return the artefact as it is now in a numbered frame, None where it is not seen."""
        now_s = self._cell.clock.now_s
        nests_mm = move(inverse(self.frame), self._cell.nests_at_mm(now_s))
        if self._cell.faults.holds(TrackerBlinded, now_s) or not self._faces(nests_mm):
            return None
        pose = register(self.defined_mm, nests_mm + self._errors_mm(nests_mm.shape, frame))
        left_mm = move(pose, self.defined_mm) - nests_mm
        return PoseSeen(
            to_quaternion(pose[:3, :3]),
            pose[:3, 3],
            float(np.sqrt(np.mean(np.sum(left_mm**2, axis=-1)))),
            int(np.sum(np.linalg.norm(nests_mm, axis=-1) > self.setup.reach_mm)),
        )

    def _errors_mm(self, shape: tuple[int, ...], frame: int) -> FloatArray:
        """Draw what this stop and this frame add to each nest."""
        if self._cell.noise is None:
            return np.zeros(shape)
        # By stop and frame, not from a generator that runs on: a frame that is asked for twice is the same.
        stop = (self._cell.seed, _OF_THE_CAMERA, self._cell.robot.stop_number)
        of_stop, of_frame = (
            np.random.default_rng(key).standard_normal(shape) for key in (stop, (*stop, frame))
        )
        errors: FloatArray = (self.setup.nest_mm * of_stop + self.setup.frame_mm * of_frame) / _KEPT
        return errors

    def _faces(self, nests_mm: FloatArray) -> bool:
        """Whether the side of the nests' plane that is turned away from the flange faces the camera."""
        first, second, third = nests_mm[:3]
        normal = np.cross(third - first, second - first)
        centre = nests_mm.mean(axis=0)
        # Behind the camera, which looks along its negative z axis.
        if centre[2] >= 0.0:
            return False
        cosine = float(normal @ -centre / (np.linalg.norm(normal) * np.linalg.norm(centre)))
        return cosine >= math.cos(math.radians(min(self.setup.acceptance_deg, 180.0)))


def _place(setup: CameraSetup, rng: np.random.Generator) -> FloatArray:
    """Draw the camera's frame in the world: z away from what it looks at, x level."""
    position_mm = np.array(setup.position_mm)
    z = position_mm - np.array(setup.looks_at_mm)
    z /= np.linalg.norm(z)
    x = np.cross(_UP, z)
    x /= np.linalg.norm(x)
    aimed = np.stack([x, np.cross(z, x), z], axis=-1)
    tilt = rotation(setup.tilt_rad * rng.standard_normal(3))
    return motion(position_mm + setup.position_u_mm * rng.standard_normal(3), aimed @ tilt)
