"""The rigid arm of an identified model: what an export leaves out, and its table as CSV or text to be typed.

A row of the table is RotX(alpha) TransX(a) RotY(beta) RotZ(sign * q + theta_offset) TransZ(d), angles in deg,
lengths in mm.
"""

import csv
import io
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from truepose.correction.reduced_models import (
    ControllerValues,
    ZoneError,
    nearest_arm,
    nominal_error,
    rigid_error,
    zone_targets,
)
from truepose.domain.errors import UnsuitableModelError
from truepose.domain.identification import Model
from truepose.domain.robot import FramePlacement, JointRow
from truepose.identification.model.estimates import RigidArm, rigid_arm
from truepose.messages.catalogue import english
from truepose.messages.message import Message, message

_GEOMETRY: Final = ("base", "tool", "geometry")
# Two draws of targets: errors at those that a table was fitted to would be too small.
_FIT_SEED, _JUDGE_SEED = 1, 2


@dataclass(frozen=True, slots=True)
class Subject:
    """A model as others can take it."""

    model: Model
    arm: RigidArm
    fitted: bool  # the table was fitted to the full model, else it is the identified one
    error: ZoneError | None  # of the arm against the full model; None: nobody can say
    nominal: ZoneError | None  # of the nominal robot against the full model

    @property
    def left_out(self) -> dict[str, int]:
        """Effects that others cannot take, and how many parameters each has."""
        return dict(Counter(parameter.effect for parameter in self.arm.left_out))


def subject_of(model: Model, *, fitted: bool = False) -> Subject:
    """Return a model as others can take it.

    Parameters
    ----------
    model : Model
    fitted : bool
        Fit base, tool and table to the full model over the measured zone, in the place of those identified.

    Raises
    ------
    UnsuitableModelError
        It shall be fitted, and the model does not know its zone or needs measured torques.
    """
    arm = _fitted(model) if fitted else rigid_arm(model)
    error, nominal = rigid_error(model, arm, _JUDGE_SEED), nominal_error(model, _JUDGE_SEED)
    return Subject(model, arm, fitted, error, nominal)


def _fitted(model: Model) -> RigidArm:
    targets = zone_targets(model, _FIT_SEED)
    if targets is None:
        raise UnsuitableModelError(
            "A table can be fitted only to a model that states its measured zone and needs no measured "
            "torques: identify again with this version, without torques, or export the identified table."
        )
    return nearest_arm(model, targets, _GEOMETRY)


def remarks(subject: Subject) -> Iterator[Message]:
    """Yield what the file does not hold, and what that costs."""
    if not subject.left_out:
        yield message("exports.whole")
    for effect, count in subject.left_out.items():
        yield message("exports.left_out", effect=effect, count=count)
    if subject.fitted:
        yield message("exports.fitted")
    yield from _costs(subject)


def _costs(subject: Subject) -> Iterator[Message]:
    if subject.error is None or subject.nominal is None:
        yield message("exports.error_unknown")
        return
    yield message(
        "exports.error",
        mean_mm=subject.error.mean_mm,
        largest_mm=subject.error.max_mm,
        nominal_mm=subject.nominal.mean_mm,
        nominal_largest_mm=subject.nominal.max_mm,
    )
    if not subject.fitted and subject.error.mean_mm > subject.nominal.mean_mm:
        yield message("exports.worse")


# Column, field of a row, factor to the unit of the column.
_QUANTITIES: Final = (
    ("alpha_deg", "alpha_rad", math.degrees(1.0)),
    ("a_mm", "a_mm", 1.0),
    ("beta_deg", "beta_rad", math.degrees(1.0)),
    ("theta_offset_deg", "theta_offset_rad", math.degrees(1.0)),
    ("d_mm", "d_mm", 1.0),
)
_DECIMALS: Final = {"deg": 6, "mm": 4}  # 20 nm at a metre, 0.1 um


def table_csv(subject: Subject) -> str:
    """Return one line per joint in full digits: value, standard uncertainty, nominal value of each quantity.

    An uncertainty is empty where no parameter moved the quantity.
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    names = [name for name, *_ in _QUANTITIES]
    columns = [column for name in names for column in (name, f"u_{name}", f"nominal_{name}")]
    writer.writerow(["joint", "sign", *columns])
    for number, row in enumerate(subject.arm.robot.joints):
        writer.writerow([number + 1, row.sign, *_cells(subject, number)])
    return stream.getvalue()


def table_text(subject: Subject) -> str:
    """Return the table with base, nests and remarks, for people."""
    head = ["joint", *(part for name, *_ in _QUANTITIES for part in (name, "u")), "sign"]
    rows = [[str(k + 1), *_printed(subject, k, row)] for k, row in enumerate(subject.arm.robot.joints)]
    return "\n".join([
        subject.model.robot.name,
        "RotX(alpha) TransX(a) RotY(beta) RotZ(sign * q + theta_offset) TransZ(d)",
        "",
        *_aligned([head, *rows]),
        "",
        f"base in the frame of the readings: {placement_words(subject.arm.base)}",
        *(f"nest {nest.nest}: {point_words(nest.centre_mm)}" for nest in subject.arm.nests),
        "",
        *(english(sentence) for sentence in dhm_remarks(subject)),
        "",
    ])


def dhm_remarks(subject: Subject) -> Iterator[Message]:
    """Yield what the table does not hold."""
    yield from remarks(subject)
    yield message("exports.dhm.base")


def placement_words(placement: FramePlacement) -> str:
    """Return a placement Trans RotX RotY RotZ with its units."""
    lengths = point_words((placement.x_mm, placement.y_mm, placement.z_mm))
    angles = (placement.rx_rad, placement.ry_rad, placement.rz_rad)
    turns = (f"r{axis} {math.degrees(angle):.6f} deg" for axis, angle in zip("xyz", angles, strict=True))
    return f"{lengths}, {', '.join(turns)}"


def point_words(point_mm: Sequence[float]) -> str:
    """Return a point with its unit."""
    return ", ".join(f"{axis} {value:.4f} mm" for axis, value in zip("xyz", point_mm, strict=True))


def _cells(subject: Subject, number: int) -> Iterator[float | str]:
    row, nominal = subject.arm.robot.joints[number], subject.model.robot.joints[number]
    for _, field, factor in _QUANTITIES:
        known = subject.arm.uncertainty[number].get(field)
        yield getattr(row, field) * factor
        yield "" if known is None else known * factor
        yield getattr(nominal, field) * factor


def _printed(subject: Subject, number: int, row: JointRow) -> Iterator[str]:
    for name, field, factor in _QUANTITIES:
        digits = _DECIMALS[name.rsplit("_", 1)[1]]
        known = subject.arm.uncertainty[number].get(field)
        yield f"{getattr(row, field) * factor:.{digits}f}"
        yield "-" if known is None else f"{known * factor:.{digits}f}"
    yield f"{row.sign:+d}"


def _aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))


def values_text(model: Model, values: ControllerValues) -> str:
    """Return the values, their accuracy and what they mean."""
    return "\n".join([
        model.robot.name,
        "",
        "joint zeros: true angle minus the angle that the controller shows",
        *(f"  joint {k}: {math.degrees(zero):.5f} deg" for k, zero in enumerate(values.joint_zeros_rad, 1)),
        "",
        f"base in the frame of the readings: {placement_words(values.base)}",
        f"frame of the readings in the base: {placement_words(values.world)}",
        "",
        *(f"tool point at nest {nest.nest}: {point_words(nest.centre_mm)}" for nest in values.tool_points),
        *_tool_frame(values),
        "",
        *(english(sentence) for sentence in controller_remarks(values)),
        "",
    ])


def _tool_frame(values: ControllerValues) -> Iterator[str]:
    if values.tool_frame is not None:
        yield f"tool frame of nests 1, 2, 3: {placement_words(values.tool_frame)}"


def controller_remarks(values: ControllerValues) -> Iterator[Message]:
    """Yield what the values reach, and how to read them."""
    yield message("exports.controller.nominal", **_sizes(values.nominal))
    yield message("exports.controller.reached", **_sizes(values.controller))
    yield message("exports.controller.model", **_sizes(values.model))
    yield message("exports.controller.angles")
    yield message("exports.controller.first_joint")


def _sizes(error: ZoneError) -> dict[str, float]:
    return {"mean_mm": error.mean_mm, "largest_mm": error.max_mm}
