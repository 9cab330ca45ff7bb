"""What whoever reads a prediction or a judgement of a model must know beside the numbers, as sentences."""

from collections.abc import Iterator
from typing import Final

from truepose.domain.measurement.campaign import Readings, Stops
from truepose.domain.results.identification import Model
from truepose.domain.sentences import Sentence, Text, said, together
from truepose.effects.base.base_frame import NAME as BASE
from truepose.identification import unpredictable, unpredictable_readings
from truepose.judgement.iso9283.judged import PoseTest

_PROVE_LITTLE: Final = {
    1: "poses.prove_little.one",
    3: "poses.prove_little.three",
    5: "poses.prove_little.five",
}


def prediction_cautions(model: Model, stops: Stops) -> Iterator[Sentence]:
    """Yield what the predictions at these stops do not contain."""
    yield from _unseen_base(model)
    for sentence in unpredictable(model, stops):
        yield said("cautions.predicted", sentence=sentence)


def validation_cautions(model: Model, readings: Readings) -> Iterator[Sentence]:
    """Yield what the judgement of a model by these readings does not contain."""
    yield from unpredictable_readings(model, readings)
    if readings.quantity == "position":
        yield from _unseen_base(model)


def pose_test_caution(test: PoseTest) -> Text:
    """Return what a test of ISO 9283 does not prove, with the figures that say more beside its own."""
    proved = said(_PROVE_LITTLE[test.poses], here=_here(test), elsewhere=_elsewhere(test))
    return together(proved, said("poses.mixed", poses=test.mixed) if test.mixed else "")


def _here(test: PoseTest) -> Text:
    worst = test.identified.largest("AP", "p")
    if worst is None:
        return ""
    return said("poses.here", accuracy_mm=worst.value, pose=worst.subject)


def _elsewhere(test: PoseTest) -> Sentence:
    if test.work_space is None:
        return said("poses.nowhere_else", claimed_mm=test.claimed_mm)
    seen = test.work_space.identified
    return said("poses.elsewhere", readings=seen.n, mean_mm=seen.mean_mm, largest_mm=seen.max_mm)


def _unseen_base(model: Model) -> Iterator[Sentence]:
    """Say of a model of lengths that its positions stand or fall with the stated base."""
    if (model.nominal_anchors or model.targets) and BASE not in model.effects:
        yield said("cautions.unseen_base")
