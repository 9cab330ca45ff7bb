"""A resampling as a document: what `resample --json` prints."""

from truepose.exchange.json_text import Json
from truepose.exchange.models.document import file_factor, file_unit
from truepose.exchange.outgoing import Quantities, Quantity
from truepose.exchange.results.document_base import Document
from truepose.identification.resampling import ParameterSpread, Spread, Way


class SpreadDocument(Document):
    """How a parameter scattered, in the unit that it names."""

    name: str
    effect: str
    unit: str
    value: Quantity
    standard_uncertainty: Quantity
    standard_deviation: Quantity
    bias: Quantity
    interval_95: Quantities


class ResamplingDocument(Document):
    """What `truepose resample --json` prints."""

    robot: str
    by: Way
    seed: int
    draws: int
    not_converged: int
    parameters: list[SpreadDocument]


def resampling_document(spread: Spread, robot: str, seed: int) -> dict[str, Json]:
    """Return the document of a resampling."""
    return ResamplingDocument(
        robot=robot,
        by=spread.way,
        seed=seed,
        draws=spread.draws,
        not_converged=spread.not_converged,
        parameters=[in_units_of_files(one) for one in spread.parameters],
    ).printed()


def in_units_of_files(one: ParameterSpread) -> SpreadDocument:
    """Return a parameter's spread in the unit that files use and that it then names."""
    factor = file_factor(one.unit)
    return SpreadDocument(
        name=one.name,
        effect=one.effect,
        unit=file_unit(one.unit),
        value=one.value * factor,
        standard_uncertainty=one.standard_uncertainty * factor,
        standard_deviation=one.standard_deviation * factor,
        bias=one.bias * factor,
        interval_95=[bound * factor for bound in one.interval_95],
    )
