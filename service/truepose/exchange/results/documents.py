"""Identifications and validations as JSON documents: angles in degrees, NaN as null."""

from collections.abc import Sequence

from truepose.domain.results import (
    Identification,
    NominalAndIdentified,
    Outlier,
    Parameter,
    PureError,
    Statistics,
    Validation,
)
from truepose.exchange.json_text import Json, number_or_null
from truepose.exchange.models.document import file_factor, file_unit


def identification_document(identification: Identification, robot_name: str) -> dict[str, Json]:
    """Return what `identify --json` prints: one document, whatever the status.

    `statistics` holds `calibration`, and `validation` or in its place `cross_validation`; a block is
    absent where nothing could be computed. `calibration_without_outliers`, `pure_error` and details of
    the outliers are additions to the promised keys.
    """
    counts = identification.counts
    return {
        "robot": robot_name,
        "status": identification.status.value,
        "message": identification.message,
        "quantity": identification.quantity,
        "effects": list(identification.effects),
        "counts": {
            "configurations": counts.configurations,
            "observations": counts.observations,
            "parameters": counts.parameters,
            "outliers": counts.outliers,
        },
        "parameters": [_parameter(parameter) for parameter in identification.parameters],
        "not_identifiable": [
            {"parameters": list(group.parameters), "reason": group.reason}
            for group in identification.not_identifiable
        ],
        "outliers": _outliers(identification.outliers),
        "statistics": _statistics_blocks(identification),
        "chi2_per_dof": number_or_null(identification.chi2_per_dof),
        "pure_error": _pure_error(identification.pure_error),
    }


def validation_document(validation: Validation) -> dict[str, Json]:
    """Return what `validate --json` prints; `distance` is null where there are no pairs."""
    return {
        "quantity": validation.quantity,
        "position": _pair(validation.position),
        "distance": None if validation.distance is None else _pair(validation.distance),
        "limit_mm": validation.limit_mm,
        "pass": validation.passed,
    }


def statistics_document(statistics: Statistics) -> dict[str, Json]:
    """Return a statistics block: the same six keys everywhere."""
    return {
        "n": statistics.n,
        "mean_mm": number_or_null(statistics.mean_mm),
        "rms_mm": number_or_null(statistics.rms_mm),
        "sd_mm": number_or_null(statistics.sd_mm),
        "max_mm": number_or_null(statistics.max_mm),
        "noise_mm": number_or_null(statistics.noise_mm),
    }


def _pair(pair: NominalAndIdentified) -> dict[str, Json]:
    return {"nominal": statistics_document(pair.nominal), "identified": statistics_document(pair.identified)}


def _statistics_blocks(identification: Identification) -> dict[str, Json]:
    cross_validation = identification.cross_validation if identification.validation is None else None
    positions = identification.positions
    blocks = {
        "calibration": identification.calibration,
        "calibration_without_outliers": identification.calibration_without_outliers,
        "validation": identification.validation,
        "cross_validation": cross_validation,
        "validation_position": None if positions is None else positions.tied,
        "validation_position_aligned": None if positions is None else positions.aligned,
    }
    # Held-out positions judge a model of lengths where no lengths were held out.
    if blocks["validation"] is None:
        blocks["validation"] = blocks["validation_position"] or blocks["validation_position_aligned"]
    return {name: _pair(block) for name, block in blocks.items() if block is not None}


def _parameter(parameter: Parameter) -> dict[str, Json]:
    factor = file_factor(parameter.unit)
    return {
        "name": parameter.name,
        "effect": parameter.effect,
        "value": number_or_null(parameter.value * factor),
        "unit": file_unit(parameter.unit),
        "standard_uncertainty": number_or_null(parameter.standard_uncertainty * factor),
        "prior_width": number_or_null(parameter.prior_width * factor),
    }


def _outliers(outliers: Sequence[Outlier]) -> list[Json]:
    return [
        {
            "config": outlier.config,
            "reason": outlier.reason,
            "nest": outlier.nest,
            "row": outlier.row,
            "residual_mm": number_or_null(outlier.residual_mm),
        }
        for outlier in outliers
    ]


def _pure_error(pure_error: PureError | None) -> dict[str, Json] | None:
    if pure_error is None:
        return None
    return {
        "revisits": pure_error.revisits,
        "degrees_of_freedom": pure_error.degrees_of_freedom,
        "repeatability_mm": number_or_null(pure_error.repeatability_mm),
        "lack_of_fit_ratio": number_or_null(pure_error.lack_of_fit_ratio),
        "p_value": number_or_null(pure_error.p_value),
    }
