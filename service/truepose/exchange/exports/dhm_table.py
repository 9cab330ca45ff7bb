"""The identified DH-Modified table: CSV where the file's name says so, else text to be read and typed.

RotX(alpha) TransX(a) RotY(beta) RotZ(sign * q + theta_offset) TransZ(d), angles in deg, lengths in mm.
"""

import csv
import io
import math
from collections.abc import Iterator, Sequence
from typing import Final

from truepose.domain.robot import FramePlacement, JointRow
from truepose.domain.sentences import Sentence, said
from truepose.exchange.exports.subject import Subject, remarks
from truepose.words.catalogue import english

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


def dhm_remarks(subject: Subject) -> Iterator[Sentence]:
    """Yield what the table does not hold."""
    yield from remarks(subject)
    yield said("exports.dhm.base")


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
