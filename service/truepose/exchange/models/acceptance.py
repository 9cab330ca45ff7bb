"""What is accepted of a model file before anything is computed with it, and before a cell takes it.

A file that was edited is refused. A model that moves the tool beyond a limit, or has values far from their
priors, is refused where a robot will follow it; where nothing but figures comes of it, a file as truepose
wrote it is only remarked on, since a validation is how one finds out. The limit is wider for a file that is
as truepose wrote it: its shift was identified from readings, and is stated.
"""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from truepose.domain.cell import MODEL_SHIFT_MM, Cell
from truepose.domain.errors import UnsuitableModelError
from truepose.domain.identification import Model
from truepose.domain.robot import Robot
from truepose.exchange.errors import ImplausibleModelError, InputFileError
from truepose.exchange.models.digest import Integrity
from truepose.exchange.models.document import file_factor, file_unit
from truepose.exchange.models.file import ModelFile, model_file_from_text, read_model_file
from truepose.exchange.robots.named import with_known_limits
from truepose.messages.message import Message, message
from truepose.validation.model_comparison import (
    FLANGE,
    FarValue,
    LargestShift,
    far_values,
    largest_shift,
    moved_to,
)

_MOST_NAMED: Final = 3
# Intact models of simulated arms reach 7 mm at the corners of their zone, and arms as built vary more. What
# is off by more than this has been described wrongly, rather than built inaccurately.
_IDENTIFIED_SHIFT_MM: Final = 20.0
_NAMES: Final = {
    Integrity.EDITED: "model_file.edited",
    Integrity.NO_DIGEST: "model_file.no_digest",
}


@dataclass(frozen=True, slots=True)
class Acceptance:
    """What somebody accepts of a model file."""

    max_shift_mm: float | None = None  # None: and no value far from its prior
    edited: bool = False


DEFAULT: Final = Acceptance()


@dataclass(frozen=True, slots=True)
class CheckedModel:
    """A model that was accepted, with what was seen on it."""

    model: Model
    integrity: Integrity
    shift: LargestShift
    remarks: tuple[Message, ...]

    @property
    def document(self) -> dict[str, str | float]:
        """Return what JSON documents say of the model file."""
        return {"digest": self.integrity.value, "largest_shift_mm": self.shift.shift_mm}


def read_checked_model(
    file: Path, acceptance: Acceptance = DEFAULT, *, robot_follows: bool = True
) -> CheckedModel:
    """Read a model file that is accepted.

    Raises
    ------
    EditedFileError
        It was edited.
    ImplausibleModelError
        It moves the tool beyond the limit, or has values far from their priors.
    InputFileError
        It cannot be read.
    """
    found = read_model_file(file, accept_edited=acceptance.edited)
    # An intact digest says that truepose wrote the values, which were identified from readings. It proves no
    # author, so the shift is looked at either way (decision 0074).
    usual_mm = _IDENTIFIED_SHIFT_MM if found.integrity is Integrity.INTACT else MODEL_SHIFT_MM
    plausibility = _plausibility(found.model, usual_mm, acceptance.max_shift_mm)
    # A figure moves no robot: there an intact file is only remarked on, since a validation is how one finds
    # out (decision 0074).
    if plausibility.beyond and (robot_follows or found.integrity is not Integrity.INTACT):
        raise ImplausibleModelError(_refusal(found.model.robot, plausibility), file=file.name)
    remarks = tuple(_remarks(found, plausibility))
    return CheckedModel(found.model, found.integrity, plausibility.shift, remarks)


def require_plausible(model: Model, name: str, max_shift_mm: float | None = None) -> None:
    """Refuse a model from memory that a robot shall follow; raises ImplausibleModelError."""
    plausibility = _plausibility(model, _IDENTIFIED_SHIFT_MM, max_shift_mm)
    if plausibility.beyond:
        raise ImplausibleModelError(_refusal(model.robot, plausibility), file=name)


@dataclass(frozen=True, slots=True)
class _Plausibility:
    shift: LargestShift
    far: tuple[FarValue, ...]
    limit_mm: float
    stated: bool  # somebody stated the limit, and then the values of parameters as well are accepted

    @property
    def beyond(self) -> bool:
        return self.shift.shift_mm > self.limit_mm or (bool(self.far) and not self.stated)


def _plausibility(model: Model, usual_mm: float, max_shift_mm: float | None) -> _Plausibility:
    limit_mm = usual_mm if max_shift_mm is None else max_shift_mm
    shift = largest_shift(with_known_limits(model))
    return _Plausibility(shift, far_values(model), limit_mm, stated=max_shift_mm is not None)


def _remarks(found: ModelFile, seen: _Plausibility) -> Iterator[Message]:
    if found.integrity in _NAMES:
        yield message(_NAMES[found.integrity])
    if seen.far and not seen.stated:
        yield message("model_file.far")
    if seen.shift.shift_mm > MODEL_SHIFT_MM:
        key = "model_file.shift" if seen.shift.shift_mm > seen.limit_mm else "model_file.usual_shift"
        yield message(key, shift_mm=seen.shift.shift_mm, limit_mm=MODEL_SHIFT_MM)


def _refusal(robot: Robot, seen: _Plausibility) -> str:
    named = f"; {far_sentence(seen.far)}" if seen.far else ""
    accepted_mm = math.ceil(seen.shift.shift_mm + 0.5)
    return (
        f"the model moves the tool of {robot.name} by up to {shift_sentence(seen.shift)}, and up to "
        f"{seen.limit_mm:g} mm is accepted{named}; identify again, or, if the robot truly is that far off, "
        f"accept the model with --max-shift-mm {accepted_mm} (in a notebook max_shift_mm={accepted_mm})"
    )


def shift_sentence(shift: LargestShift) -> str:
    """Return size and place of a shift."""
    joints = ", ".join(f"{math.degrees(angle):.1f}" for angle in shift.joints_rad)
    where = "at the flange" if shift.nest == FLANGE else f"at nest {shift.nest}"
    return f"{shift.shift_mm:.4g} mm {where} (joints {joints} deg)"


def far_sentence(far: tuple[FarValue, ...]) -> str:
    """Return which values are far from their priors; those that are farthest by name."""
    named = [_named(one) for one in far[:_MOST_NAMED]]
    more = f" and {len(far) - _MOST_NAMED} more" if len(far) > _MOST_NAMED else ""
    return f"far from their priors: {', '.join(named)}{more}"


def _named(far: FarValue) -> str:
    one, factor = far.parameter, file_factor(far.parameter.unit)
    value, width = one.value * factor, one.prior_width * factor
    return f"{one.name} = {value:.4g} {file_unit(one.unit)} (prior {width:.3g})"


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
            f"({cell.robot_key}), with a different joint table. Push a model of the robot in this cell."
        )
    known = [nest.centre_mm for nest in cell.nests]
    apart_mm = _apart_mm([nest.centre_mm for nest in model.nests], known)
    if apart_mm > _SAME_NEST_MM:
        raise UnsuitableModelError(
            f"The model was made with another tool, whose nests are up to {apart_mm:.3g} mm away from "
            f"those of this cell. {_THEN}"
        )
    # Where the cell file has the nominal robot, not where the model says: else a wrong base would hide in its
    # own reference (decision 0074).
    here = moved_to(model, cell.base_nominal, nests_known=bool(known) and None not in known)
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
    # At least the shift that is there: what somebody saw and confirmed on a page holds for no larger one.
    confirmed = accepted_shift_mm is not None and handed.shift.shift_mm <= accepted_shift_mm
    if handed.needs_confirmation and not confirmed:
        far = f", with values {far_sentence(handed.far)}" if handed.far else ""
        raise UnsuitableModelError(
            f"The model moves the tool by up to {shift_sentence(handed.shift)}{far}; this cell accepts up to "
            f"{handed.limit_mm:g} mm. To accept the model, confirm that shift (accepted_shift_mm)."
        )
    return handed.model


def _read(document: Mapping[str, Any]) -> ModelFile:
    try:
        return model_file_from_text(json.dumps(document).encode(), "handed-down model")
    except InputFileError as error:
        raise UnsuitableModelError(
            f"The pushed model cannot be read: {error} Push a model file as downloaded."
        ) from error


def _same_table(one: Robot, other: Robot) -> bool:
    return one.n_joints == other.n_joints and bool(
        np.allclose(one.table, other.table, rtol=0.0, atol=_ROUNDING)
    )


def _apart_mm(
    centres_mm: list[tuple[float, float, float]], known_mm: list[tuple[float, float, float] | None]
) -> float:
    """Return how far nests lie apart at most; a cell that does not know its nests refuses none."""
    # Nests that the cell does not know are found by each session; there is nothing to compare.
    if any(centre is None for centre in known_mm) or not known_mm:
        return 0.0
    if len(centres_mm) != len(known_mm):
        raise UnsuitableModelError(
            f"The model was made with a tool of {len(centres_mm)} nests; the tool of this cell has "
            f"{len(known_mm)}. {_THEN}"
        )
    differences = np.asarray(centres_mm, dtype=float) - np.asarray(known_mm, dtype=float)
    return float(np.linalg.norm(differences, axis=1).max())
