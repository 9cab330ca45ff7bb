"""How well the camera measures, and when it sees the artefact."""

from dataclasses import dataclass

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import Vector


@dataclass(frozen=True, slots=True)
class CameraSetup:
    """Where the camera stands, how good it is, and how the artefact must be turned to be seen."""

    position_mm: Vector = (2200.0, 0.0, 900.0)  # world
    looks_at_mm: Vector = (0.0, 0.0, 0.0)
    position_u_mm: float = 5.0  # the stand is about there, one sigma per axis
    tilt_rad: float = 0.002
    reach_mm: float = 3000.0  # of the measuring volume
    nest_mm: float = 0.045  # of each nest's coordinates, the same as long as the arm stands
    frame_mm: float = 0.010  # of one frame besides
    artefact_mm: float = 0.040  # by which the artefact's definition is off in each nest's coordinates, always
    acceptance_deg: float = 15.0  # between normal and line of sight; 180: markers on all sides
    frame_hz: float = 60.0

    def __post_init__(self) -> None:
        for name in ("position_u_mm", "tilt_rad", "nest_mm", "frame_mm", "artefact_mm"):
            if getattr(self, name) < 0.0:
                raise ScenarioError(f'key "{name}" must be 0 or more, not {getattr(self, name)}')
        for name in ("reach_mm", "acceptance_deg", "frame_hz"):
            if getattr(self, name) <= 0.0:
                raise ScenarioError(f'key "{name}" must be above 0, not {getattr(self, name)}')
        if self.position_mm[:2] == self.looks_at_mm[:2]:
            raise ScenarioError('keys "position_mm" and "looks_at_mm" must not be one above the other')
