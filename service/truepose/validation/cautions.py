"""What whoever reads a prediction or a judgement of a model must know beside the numbers, as sentences.

None of them changes a figure. They are yielded where they apply, in the order in which they are to be read.
"""

from collections.abc import Iterator
from typing import Final

from truepose.domain.campaign import Readings, Stops
from truepose.domain.identification import Model
from truepose.effects.frames.base_frame import NAME as BASE
from truepose.identification import unpredictable, unpredictable_readings
from truepose.messages.message import Message, Text, message, together
from truepose.validation.iso9283.pose_test import PoseTest

_PROVE_LITTLE: Final = {
    1: "poses.prove_little.one",
    3: "poses.prove_little.three",
    5: "poses.prove_little.five",
}


def prediction_cautions(model: Model, stops: Stops) -> Iterator[Message]:
    """Yield what the predictions at these stops do not contain.

    Parameters
    ----------
    model : Model
    stops : Stops

    Yields
    ------
    Message
    """
    yield from _unseen_base(model)
    for sentence in unpredictable(model, stops):
        yield message("cautions.predicted", sentence=sentence)


def validation_cautions(model: Model, readings: Readings) -> Iterator[Message]:
    """Yield what the judgement of a model by these readings does not contain.

    Parameters
    ----------
    model : Model
    readings : Readings

    Yields
    ------
    Message
    """
    yield from unpredictable_readings(model, readings)
    # Errors of lengths and contacts do not depend on where the base stands; errors of positions do.
    if readings.quantity == "position":
        yield from _unseen_base(model)


def pose_test_caution(test: PoseTest) -> Text:
    """Return what a test of ISO 9283 does not prove, with the figures that say more beside its own.

    Parameters
    ----------
    test : PoseTest

    Returns
    -------
    Text
        Of five, three or one pose; with the poses that were approached from several sides.
    """
    proved = message(_PROVE_LITTLE[test.poses], here=_here(test), elsewhere=_elsewhere(test))
    return together(proved, message("poses.mixed", poses=test.mixed) if test.mixed else "")


def _here(test: PoseTest) -> Text:
    """Return the worst AP of the identified model; "" where every pose is withheld."""
    worst = test.identified.largest("AP", "p")
    if worst is None:
        return ""
    return message("poses.here", accuracy_mm=worst.value, pose=worst.subject)


def _elsewhere(test: PoseTest) -> Message:
    """Return what was measured of the rest of the work space, else what the model lets expect there."""
    if test.work_space is None:
        return message("poses.nowhere_else", claimed_mm=test.claimed_mm)
    seen = test.work_space.identified
    return message("poses.elsewhere", readings=seen.n, mean_mm=seen.mean_mm, largest_mm=seen.max_mm)


def _unseen_base(model: Model) -> Iterator[Message]:
    """Say of a model of lengths that its positions stand or fall with the stated base."""
    if (model.nominal_anchors or model.targets) and BASE not in model.effects:
        yield message("cautions.unseen_base")
