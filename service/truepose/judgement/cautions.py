"""What whoever reads a prediction or a judgement of a model must know beside the numbers, as sentences."""

from collections.abc import Iterator

from truepose.domain.campaign import Readings, Stops
from truepose.domain.results import Model
from truepose.domain.sentences import Sentence, said
from truepose.effects.base.base_frame import NAME as BASE
from truepose.identification import unpredictable, unpredictable_readings


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


def _unseen_base(model: Model) -> Iterator[Sentence]:
    """Say of a model of lengths that its positions stand or fall with the stated base."""
    if model.nominal_anchors and BASE not in model.effects:
        yield said("cautions.unseen_base")
