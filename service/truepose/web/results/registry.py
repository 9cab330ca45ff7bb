"""Every kind of result, in the order in which a session is asked for it."""

from typing import Final

from truepose.web.results.accuracy import ACCURACY, POSE_TEST
from truepose.web.results.circles import CIRCLES
from truepose.web.results.kinds import Origin, ResultKind
from truepose.web.results.proof import PROOF
from truepose.web.results.sphere import SPHERE

KINDS: Final[tuple[ResultKind, ...]] = (PROOF, POSE_TEST, CIRCLES, SPHERE, ACCURACY)


def kind_of(origin: Origin) -> ResultKind | None:
    """Return the kind of result that a session gives; None: its readings are for something else."""
    return next((kind for kind in KINDS if kind.is_of(origin)), None)
