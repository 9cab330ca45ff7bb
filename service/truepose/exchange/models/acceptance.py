"""What is accepted of a model file before anything is computed with it.

A file that was edited is refused. A model that moves the tool beyond a limit, or has values far from their
priors, is refused where a robot will follow it; where nothing but figures comes of it, a file as truepose
wrote it is only remarked on, since a validation is how one finds out. The limit is wider for a file that is
as truepose wrote it: its shift was identified from readings, and is stated.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.domain.cell.description import MODEL_SHIFT_MM
from truepose.domain.results.identification import Model
from truepose.domain.robot import Robot
from truepose.domain.sentences import Sentence, said
from truepose.exchange.errors import ImplausibleModelError
from truepose.exchange.models.digest import Integrity
from truepose.exchange.models.document import file_factor, file_unit
from truepose.exchange.models.file import ModelFile, read_model_file
from truepose.exchange.robots.known_limits import with_known_limits
from truepose.judgement.largest_shift import (
    FLANGE,
    FarValue,
    LargestShift,
    far_values,
    largest_shift,
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
    remarks: tuple[Sentence, ...]

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
    usual_mm = _IDENTIFIED_SHIFT_MM if found.integrity is Integrity.INTACT else MODEL_SHIFT_MM
    plausibility = _plausibility(found.model, usual_mm, acceptance.max_shift_mm)
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


def _remarks(found: ModelFile, seen: _Plausibility) -> Iterator[Sentence]:
    if found.integrity in _NAMES:
        yield said(_NAMES[found.integrity])
    if seen.far and not seen.stated:
        yield said("model_file.far")
    if seen.shift.shift_mm > MODEL_SHIFT_MM:
        key = "model_file.shift" if seen.shift.shift_mm > seen.limit_mm else "model_file.usual_shift"
        yield said(key, shift_mm=seen.shift.shift_mm, limit_mm=MODEL_SHIFT_MM)


def _refusal(robot: Robot, seen: _Plausibility) -> str:
    named = f"; {far_sentence(seen.far)}" if seen.far else ""
    accepted_mm = math.ceil(seen.shift.shift_mm + 0.5)
    return (
        f"the model moves the tool of {robot.name} by up to {shift_sentence(seen.shift)}, and up to "
        f"{seen.limit_mm:g} mm is accepted{named}; identify again, or, if the robot truly is that far off, "
        f"accept it with --max-shift-mm {accepted_mm} (in a notebook max_shift_mm={accepted_mm})"
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
