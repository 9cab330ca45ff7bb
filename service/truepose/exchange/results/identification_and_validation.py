"""Identifications and validations as documents: angles in degrees, null for what is no number."""

import math
from typing import Literal, Self

from pydantic import AliasChoices, Field, model_validator

from truepose.domain.results import (
    DecisionRule,
    ErrorsByPlace,
    Identification,
    NominalAndIdentified,
    Parameter,
    Shell,
    Statistics,
    Status,
    TurnPair,
    TurnStatistics,
    Validation,
    Verdict,
)
from truepose.exchange.json_text import Json
from truepose.exchange.models.document import in_file_units
from truepose.exchange.outgoing import Quantity
from truepose.exchange.results.document_base import Document, Spoken


class StatisticsDocument(Document):
    """Norms of errors of n observations; `noise_mm` is the mean norm that stated uncertainties alone give."""

    n: int = Field(examples=[50])
    mean_mm: Quantity = Field(examples=[0.021])
    rms_mm: Quantity = Field(examples=[0.023])
    sd_mm: Quantity = Field(examples=[0.009])
    max_mm: Quantity = Field(examples=[0.047])
    noise_mm: Quantity = Field(examples=[0.019])


class PairDocument(Document):
    """The same statistics for the nominal model and the identified one."""

    nominal: StatisticsDocument
    identified: StatisticsDocument


class TurnStatisticsDocument(Document):
    """Angles between measured orientations and a model's; `noise_deg`: what stated noise alone gives."""

    n: int = Field(examples=[50])
    mean_deg: Quantity = Field(examples=[0.035])
    rms_deg: Quantity = Field(examples=[0.038])
    sd_deg: Quantity = Field(examples=[0.015])
    max_deg: Quantity = Field(examples=[0.081])
    noise_deg: Quantity = Field(examples=[0.043])

    @model_validator(mode="before")
    @classmethod
    def _in_degrees(cls, turns: object) -> object:
        if not isinstance(turns, TurnStatistics):
            return turns
        figures = ("mean", "rms", "sd", "max", "noise")
        return {"n": turns.n} | {
            f"{name}_deg": math.degrees(getattr(turns, f"{name}_rad")) for name in figures
        }


class TurnPairDocument(Document):
    """The same for the nominal model and the identified one."""

    nominal: TurnStatisticsDocument
    identified: TurnStatisticsDocument


class BlocksDocument(Document):
    """Statistics by the readings they are of; `cross_validation` stands where there is no `validation`."""

    calibration: PairDocument | None = None
    calibration_without_outliers: PairDocument | None = None
    validation: PairDocument | None = None
    cross_validation: PairDocument | None = None
    validation_relative: PairDocument | None = Field(
        None, description="Held-out positions after the best rigid alignment: the base may stand anywhere."
    )
    cross_validation_relative: PairDocument | None = None
    validation_position: PairDocument | None = Field(
        None, description="Of a model of lengths: held-out positions, tied to the world by the measured cups."
    )
    validation_position_aligned: PairDocument | None = Field(
        None, description="Of a model of lengths: held-out positions after the best rigid alignment."
    )
    calibration_orientation: TurnPairDocument | None = Field(None, description="Where poses were read.")
    validation_orientation: TurnPairDocument | None = None


class ParameterDocument(Document):
    """An identified parameter in the unit that it names."""

    name: str = Field(examples=["a_3"])
    effect: str = Field(examples=["geometry"])
    value: Quantity = Field(examples=[0.236])
    unit: str = Field(examples=["mm"])
    standard_uncertainty: Quantity = Field(examples=[0.011])
    prior_width: Quantity = Field(description="What was expected of it beforehand.", examples=[0.5])

    @model_validator(mode="before")
    @classmethod
    def _in_units_of_files(cls, parameter: object) -> object:
        return in_file_units(parameter) if isinstance(parameter, Parameter) else parameter


class NotIdentifiableDocument(Document):
    """Parameters that the data see only together, or not at all."""

    parameters: list[str] = Field(examples=[["theta_6", "nest_1_x"]])
    reason: Spoken


class OutlierDocument(Document):
    """A reading that was given no weight; it stays in the data."""

    config: int
    reason: Spoken
    nest: int = Field(description="Tool nest.")
    row: int = Field(description="Of its table, from 0.")
    residual_mm: Quantity


class CountsDocument(Document):
    """How many of what took part."""

    configurations: int
    observations: int
    parameters: int
    outliers: int


class PureErrorDocument(Document):
    """What revisited configurations say: repeatability, and whether the model lacks something beyond it."""

    revisits: int
    degrees_of_freedom: int
    repeatability_mm: Quantity = Field(description="Standard deviation per axis, from revisits alone.")
    lack_of_fit_ratio: Quantity
    p_value: Quantity


class IdentificationDocument(Document):
    """What `truepose identify --json` prints."""

    robot: str
    status: Status
    message: Spoken
    quantity: Literal["position", "length"]
    effects: list[str]
    counts: CountsDocument
    parameters: list[ParameterDocument]
    not_identifiable: list[NotIdentifiableDocument]
    outliers: list[OutlierDocument]
    statistics: BlocksDocument
    chi2_per_dof: Quantity
    pure_error: PureErrorDocument | None = Field(description="Null where no configuration was revisited.")

    @classmethod
    def of_robot(cls, identification: Identification, robot: str) -> Self:
        """Return the document of an identification, whatever its status."""
        return cls.of(identification, robot=robot, statistics=_blocks(identification))


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


class HistogramDocument(Document):
    """Counts in bins of one width."""

    width_mm: Quantity = Field(examples=[0.02])
    from_mm: Quantity = Field(description="Where the first bin begins.", examples=[-0.4])
    counts: list[int] = Field(examples=[[3, 41, 38, 2]])


class SignedErrorsDocument(Document):
    """What the signs of errors tell, seen minus predicted."""

    mean_mm: Quantity = Field(description="With sign.", examples=[0.004])
    positive_share: Quantity = Field(examples=[0.52])
    histogram: HistogramDocument


class DistanceErrorsDocument(Document):
    """Errors of the distances between all pairs of points, with their signs."""

    nominal: SignedErrorsDocument
    identified: SignedErrorsDocument


class ZoneDocument(Document):
    """Where the readings lay that made the model; not `stated`: that judge it."""

    x_mm: Quantity
    y_mm: Quantity
    z_mm: Quantity
    radius_mm: Quantity
    stated: bool


class ShellDocument(PairDocument):
    """Errors of the readings at some distance from something."""

    from_mm: Quantity
    to_mm: Quantity


class BranchDocument(PairDocument):
    """Errors of the readings in one posture of the arm."""

    branch: str = Field(examples=["front/up/no flip"])


class PlacesDocument(Document):
    """Where errors are large; shells and branches without a reading are left out."""

    zone: ZoneDocument
    from_zone: list[ShellDocument] = Field(description="By distance from the middle of the zone.")
    from_axis: list[ShellDocument] = Field(description="By distance from the line of axis 1.")
    branches: list[BranchDocument] = Field(
        description="Empty where the arm has no closed inverse: its branches have no names then."
    )

    @model_validator(mode="before")
    @classmethod
    def _flat(cls, places: object) -> object:
        if not isinstance(places, ErrorsByPlace):
            return places
        x, y, z = places.zone_centre_mm
        return {
            "zone": {
                "x_mm": x,
                "y_mm": y,
                "z_mm": z,
                "radius_mm": places.zone_radius_mm,
                "stated": places.zone_stated,
            },
            "from_zone": [_shell(shell) for shell in places.from_zone],
            "from_axis": [_shell(shell) for shell in places.from_axis],
            "branches": [_of_both(one.errors, branch=one.branch) for one in places.branches],
        }


def _shell(shell: Shell) -> dict[str, object]:
    return _of_both(shell.errors, from_mm=shell.from_mm, to_mm=shell.to_mm)


def _of_both(errors: NominalAndIdentified, **where: object) -> dict[str, object]:
    return where | {"nominal": errors.nominal, "identified": errors.identified}


class DecisionDocument(Document):
    """Whether the largest error stays within the limit (ISO 14253-1), and the reading that decides it."""

    rule: DecisionRule
    limit_mm: Quantity
    error_mm: Quantity
    guard_mm: Quantity = Field(description="1.65 standard uncertainties of measuring it; 0 by simple rule.")
    verdict: Verdict


class FigureUncertaintyDocument(Document):
    """Standard uncertainty of each figure of that name, to first order (GUM)."""

    mean_mm: Quantity = Field(examples=[0.002])
    rms_mm: Quantity = Field(examples=[0.002])
    sd_mm: Quantity = Field(examples=[0.001])
    max_mm: Quantity = Field(examples=[0.008])
    signed_mean_mm: Quantity | None = Field(None, description="Of distances: of the mean with sign.")


class UncertaintyPairDocument(Document):
    """The same for the nominal model and the identified one."""

    nominal: FigureUncertaintyDocument
    identified: FigureUncertaintyDocument


class ValidationUncertaintyDocument(Document):
    """How well the figures of `position`, `relative` and `distance` are known."""

    position: UncertaintyPairDocument | None
    relative: UncertaintyPairDocument | None
    distance: UncertaintyPairDocument | None


class ValidationDocument(Document):
    """What `truepose validate --json` prints; `distance` is null where there are no pairs."""

    quantity: Literal["position", "length"]
    position: PairDocument
    relative: PairDocument | None = Field(
        None, description="Positions after the best rigid alignment: the base may stand anywhere."
    )
    distance: PairDocument | None
    distance_errors: DistanceErrorsDocument | None = Field(
        None, description="All pairs, with sign and histogram; null where there are no pairs."
    )
    places: PlacesDocument | None = Field(None, description="Null: of a program that did not tell it yet.")
    uncertainty: ValidationUncertaintyDocument | None = Field(
        None, description="Null: of a program that did not tell it yet."
    )
    orientation: TurnPairDocument | None = Field(
        None, validation_alias=AliasChoices("turns", "orientation"), description="Null: none were read."
    )
    limit_mm: Quantity
    decision: DecisionDocument | None = Field(None, description="Null without a limit.")
    passed: bool = Field(validation_alias=AliasChoices("passed", "pass"), serialization_alias="pass")


def identification_document(identification: Identification, robot_name: str) -> dict[str, Json]:
    """Return what `identify --json` prints: one document, whatever the status."""
    return IdentificationDocument.of_robot(identification, robot_name).printed()


def validation_document(validation: Validation) -> dict[str, Json]:
    """Return what `validate --json` prints."""
    return ValidationDocument.of(validation).printed()


def statistics_document(statistics: Statistics) -> dict[str, Json]:
    """Return a statistics block: the same six keys everywhere."""
    return StatisticsDocument.of(statistics).printed()
