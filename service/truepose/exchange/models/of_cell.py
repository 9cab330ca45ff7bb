"""Whether a model that somebody hands to a cell is one for it: of its robot, of its tool, and plausible."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from truepose.domain.cell.description import Cell
from truepose.domain.errors import UnsuitableModelError
from truepose.domain.results.identification import Model
from truepose.domain.robot import JointRow, Robot
from truepose.exchange.errors import InputFileError
from truepose.exchange.models.acceptance import far_sentence, shift_sentence
from truepose.exchange.models.digest import Integrity
from truepose.exchange.models.file import ModelFile, model_file_from_text
from truepose.judgement.largest_shift import FarValue, LargestShift, far_values, largest_shift, placed_at

_ROUNDING: Final = 1e-6  # of a file, in mm and rad
_SAME_NEST_MM: Final = 0.1  # two artefacts of one drawing differ by less, two tools by more
_THEN: Final = "Mount that tool and describe it in the cell file, or identify here."


@dataclass(frozen=True, slots=True)
class HandedModel:
    """A model of the robot and tool of a cell, and what whoever accepts it must know."""

    model: Model
    integrity: Integrity
    shift: LargestShift  # from the nominal robot as the cell file has it
    far: tuple[FarValue, ...]
    limit_mm: float

    @property
    def needs_confirmation(self) -> bool:
        """Whether it is accepted only by who confirms the shift."""
        return self.shift.shift_mm > self.limit_mm or bool(self.far)


def fitting_model(document: Mapping[str, Any], cell: Cell) -> HandedModel:
    """Return the model of a document as it is downloaded.

    Raises
    ------
    UnsuitableModelError
        It is no model, was edited, or is of another robot, or of another tool, than this cell has.
    """
    found = _read(document)
    model = found.model
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
    here = placed_at(model, cell.base_nominal, nests_known=bool(known) and None not in known)
    limits = cell.limits
    space = limits.calibration or cell.robot.calibration_ranges or limits.joints or cell.robot.joint_limits
    return HandedModel(
        model, found.integrity, largest_shift(here, space), far_values(here), limits.model_shift_mm
    )


def accepted_model(document: Mapping[str, Any], cell: Cell, accepted_shift_mm: float | None = None) -> Model:
    """Return the model of a document that somebody accepts, with the shift that they confirm.

    Raises
    ------
    UnsuitableModelError
        As `fitting_model`; or the shift is beyond the cell's limit, or values are far from their priors, and
        the shift was not confirmed.
    """
    handed = fitting_model(document, cell)
    confirmed = accepted_shift_mm is not None and handed.shift.shift_mm <= accepted_shift_mm
    if handed.needs_confirmation and not confirmed:
        far = f", with values {far_sentence(handed.far)}" if handed.far else ""
        raise UnsuitableModelError(
            f"The model moves the tool by up to {shift_sentence(handed.shift)}{far}; this cell accepts up to "
            f"{handed.limit_mm:g} mm. Whoever accepts it confirms that shift (accepted_shift_mm)."
        )
    return handed.model


def _read(document: Mapping[str, Any]) -> ModelFile:
    try:
        return model_file_from_text(json.dumps(document).encode(), "handed-down model")
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
