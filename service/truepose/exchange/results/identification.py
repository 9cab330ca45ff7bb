"""Identifications as documents, whatever their status, and a resampling of one."""

from typing import Annotated, Literal, Self

from pydantic import Field

from truepose.domain.identification import (
    Identification,
    NominalAndIdentified,
    Status,
    TurnPair,
)
from truepose.exchange.json_text import Json
from truepose.exchange.results.document import (
    UNIT,
    Document,
    FieldSource,
    PairDocument,
    Quantities,
    Quantity,
    Spoken,
    SpokenOutcome,
    TurnPairDocument,
    in_file_unit,
)
from truepose.exchange.results.set_aside import SetAside
from truepose.identification.resampling import Spread, Way
from truepose.validation.outcome import outcome_of


class BlocksDocument(Document):
    """Statistics by group of readings; `cross_validation` takes the place of a missing `validation`."""

    calibration: PairDocument | None = None
    calibration_without_outliers: PairDocument | None = None
    validation: PairDocument | None = None
    cross_validation: PairDocument | None = None
    validation_relative: PairDocument | None = Field(
        None,
        description="Held-out positions after the best rigid alignment, so independent of the position "
        "of the base.",
    )
    cross_validation_relative: PairDocument | None = None
    validation_position: PairDocument | None = Field(
        None,
        description="For a model of lengths: held-out positions, referred to the world frame by the "
        "measured cups.",
    )
    validation_position_aligned: PairDocument | None = Field(
        None, description="For a model of lengths: held-out positions after the best rigid alignment."
    )
    calibration_orientation: TurnPairDocument | None = Field(
        None, description="Orientation errors of the calibration readings; only if poses were measured."
    )
    validation_orientation: TurnPairDocument | None = None


class ParameterDocument(Document):
    """An identified parameter, with its unit."""

    name: str = Field(examples=["a_3"])
    effect: str = Field(examples=["geometry"])
    value: Annotated[Quantity, in_file_unit("value")] = Field(examples=[0.236])
    unit: Annotated[str, UNIT] = Field(examples=["mm"])
    standard_uncertainty: Annotated[Quantity, in_file_unit("standard_uncertainty")] = Field(examples=[0.011])
    prior_width: Annotated[Quantity, in_file_unit("prior_width")] = Field(
        description="Prior standard deviation.", examples=[0.5]
    )


class NotIdentifiableDocument(Document):
    """Parameters that cannot be identified separately, or not at all, from these data."""

    parameters: list[str] = Field(examples=[["theta_6", "nest_1_x"]])
    reason: Spoken


class OutlierDocument(Document):
    """A reading with zero weight; it remains in the data."""

    config: int
    reason: Spoken
    nest: int = Field(description="Number of the tool nest.")
    row: int = Field(description="Row of the reading in its table, starting at 0.")
    residual_mm: Quantity


class CountsDocument(Document):
    """Numbers of configurations, observations, parameters and outliers."""

    configurations: int
    observations: int
    parameters: int
    outliers: int


class PureErrorDocument(Document):
    """Result of repeat measurements: repeatability, and a test for lack of fit of the model."""

    revisits: int
    degrees_of_freedom: int
    repeatability_mm: Quantity = Field(
        description="Standard deviation per axis, from repeat measurements only."
    )
    lack_of_fit_ratio: Quantity
    p_value: Quantity


class IdentificationDocument(Document):
    """Result of `truepose identify --json`."""

    robot: str
    status: Status
    outcome: SpokenOutcome = ""
    message: Spoken
    quantity: Literal["position", "length"]
    effects: list[str]
    counts: CountsDocument
    parameters: list[ParameterDocument]
    not_identifiable: list[NotIdentifiableDocument]
    outliers: list[OutlierDocument]
    statistics: BlocksDocument
    chi2_per_dof: Quantity
    pure_error: PureErrorDocument | None = Field(
        description="Statistics of repeat measurements; null if no configuration was repeated."
    )
    set_aside: SetAside = None

    @classmethod
    def of_robot(cls, identification: Identification, robot: str) -> Self:
        """Return the document of an identification, whatever its status."""
        outcome = outcome_of(identification)
        return cls.of(identification, robot=robot, outcome=outcome, statistics=_blocks(identification))


def _blocks(identification: Identification) -> dict[str, NominalAndIdentified | TurnPair]:
    """Return the blocks that could be computed; the others are absent."""
    positions = identification.positions
    blocks: dict[str, NominalAndIdentified | TurnPair | None] = {
        "calibration": identification.calibration,
        "calibration_without_outliers": identification.calibration_without_outliers,
        "validation": identification.validation,
        "cross_validation": None if identification.validation else identification.cross_validation,
        "validation_relative": identification.relative if identification.validation else None,
        "cross_validation_relative": None if identification.validation else identification.relative,
        "validation_position": positions.tied if positions else None,
        "validation_position_aligned": positions.aligned if positions else None,
        "calibration_orientation": identification.calibration_turns,
        "validation_orientation": identification.validation_turns,
    }
    # Held-out positions judge a model of lengths where no lengths were held out.
    blocks["validation"] = (
        blocks["validation"] or blocks["validation_position"] or blocks["validation_position_aligned"]
    )
    return {name: block for name, block in blocks.items() if block is not None}


def identification_document(identification: Identification, robot_name: str) -> dict[str, Json]:
    """Return what `identify --json` prints: one document, whatever the status."""
    return IdentificationDocument.of_robot(identification, robot_name).printed()


class SpreadDocument(Document):
    """Scatter of one parameter over the resampled fits, with its unit."""

    name: str
    effect: str
    unit: Annotated[str, UNIT]
    value: Annotated[Quantity, in_file_unit("value")]
    standard_uncertainty: Annotated[Quantity, in_file_unit("standard_uncertainty")]
    standard_deviation: Annotated[Quantity, in_file_unit("standard_deviation")]
    bias: Annotated[Quantity, in_file_unit("bias")]
    interval_95: Annotated[Quantities, in_file_unit("interval_95")]


class ResamplingDocument(Document):
    """Result of `truepose resample --json`."""

    robot: str
    by: Annotated[Way, FieldSource("way")]
    seed: int
    draws: int
    not_converged: int
    parameters: list[SpreadDocument]


def resampling_document(spread: Spread, robot: str, seed: int) -> dict[str, Json]:
    """Return the document of a resampling."""
    return ResamplingDocument.of(spread, robot=robot, seed=seed).printed()
