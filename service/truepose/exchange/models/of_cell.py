"""Whether a model that somebody hands to a cell is one for it: of its robot, and of its tool."""

import json
from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np

from truepose.domain.cell.description import Cell
from truepose.domain.errors import UnsuitableModelError
from truepose.domain.results.identification import Model
from truepose.domain.robot import JointRow, Robot
from truepose.exchange.errors import InputFileError
from truepose.exchange.models.file import model_from_text

_ROUNDING: Final = 1e-6  # of a file, in mm and rad
_SAME_NEST_MM: Final = 0.1  # two artefacts of one drawing differ by less, two tools by more
_THEN: Final = "Mount that tool and describe it in the cell file, or identify here."


def fitting_model(document: Mapping[str, Any], cell: Cell) -> Model:
    """Return the model of a document as it is downloaded.

    Raises
    ------
    UnsuitableModelError
        It is no model, or of another robot, or of another tool, than this cell has.
    """
    model = _read(document)
    if model.robot.name != cell.robot.name or not _same_table(model.robot, cell.robot):
        raise UnsuitableModelError(
            f"The model is of {model.robot.name}; this cell has {cell.robot.name} "
            f"({cell.robot_key}), whose table of joints is another one. Hand down a model of that."
        )
    known = [nest.centre_mm for nest in cell.nests]
    apart_mm = _apart_mm([nest.centre_mm for nest in model.nests], known)
    if apart_mm > _SAME_NEST_MM:
        raise UnsuitableModelError(
            f"The model was made with another tool, whose nests lie up to {apart_mm:.3g} mm elsewhere. "
            f"{_THEN}"
        )
    return model


def _read(document: Mapping[str, Any]) -> Model:
    try:
        return model_from_text(json.dumps(document).encode(), "handed-down model")
    except InputFileError as error:
        raise UnsuitableModelError(
            f"What was handed down cannot be read as a model: {error} Hand down a model as it is downloaded."
        ) from error


def _same_table(one: Robot, other: Robot) -> bool:
    return one.n_joints == other.n_joints and bool(
        np.allclose(_table(one.joints), _table(other.joints), rtol=0.0, atol=_ROUNDING)
    )


def _table(joints: Iterable[JointRow]) -> list[tuple[float, ...]]:
    return [
        (row.alpha_rad, row.a_mm, row.theta_offset_rad, row.d_mm, row.beta_rad, row.sign) for row in joints
    ]


def _apart_mm(
    centres_mm: list[tuple[float, float, float]], known_mm: list[tuple[float, float, float] | None]
) -> float:
    """Return how far nests lie apart at most; a cell that does not know its nests refuses none."""
    if any(centre is None for centre in known_mm) or not known_mm:
        return 0.0
    if len(centres_mm) != len(known_mm):
        raise UnsuitableModelError(
            f"The model was made with a tool of {len(centres_mm)} nests; this cell's has {len(known_mm)}. "
            f"{_THEN}"
        )
    differences = np.asarray(centres_mm, dtype=float) - np.asarray(known_mm, dtype=float)
    return float(np.linalg.norm(differences, axis=1).max())
