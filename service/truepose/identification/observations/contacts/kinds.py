"""Which class answers for a kind of target: the one place where a further kind is registered."""

from collections.abc import Mapping
from typing import Final

from truepose.domain.measurement.targets import TargetKind
from truepose.identification.observations.contacts.against import Against
from truepose.identification.observations.contacts.centres import Centre
from truepose.identification.observations.contacts.faces import Face
from truepose.identification.observations.contacts.planes import Plane
from truepose.identification.observations.contacts.seen_balls import SeenBall

KINDS: Final[Mapping[TargetKind, Against]] = {
    TargetKind.SPHERE: Centre(),
    TargetKind.WIRE: Centre(),
    TargetKind.PLANE: Plane(),
    TargetKind.GAUGE: Plane(),
    TargetKind.BALL: SeenBall(),
    TargetKind.FACE: Face(),
}
