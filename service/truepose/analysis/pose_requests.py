"""What is asked of a plan of ISO 9283, without the numerics that answer it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from truepose.domain.session import SessionPlan
from truepose.storage.records import SessionSetup

if TYPE_CHECKING:
    from truepose.validation.iso9283.plan import Plane, PoseTestKind


@dataclass(frozen=True, slots=True)
class PoseRequest:
    """Which poses, where, how often, and for which of its tests."""

    setup: SessionSetup
    template: SessionPlan  # role, speeds and limits
    centre_mm: tuple[float, float, float] | None  # of the cube, in the base; None with the edge: chosen
    edge_mm: float | None
    plane: "Plane"
    quaternion: tuple[float, float, float, float] | None  # w first, of the flange frame in the base
    nest: int | None
    cycles: int
    test: "PoseTestKind" = "poses"
    approach_mm: float = 50.0  # of `directions`
    hours: float = 8.0  # of `drift`
