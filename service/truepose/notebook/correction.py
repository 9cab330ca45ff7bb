"""Corrected targets in a notebook."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from truepose.correction import Corrections as Found
from truepose.correction import Summary, stack_tables
from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.exchange.corrections import corrected_rows, reason_to_withhold, table_cautions
from truepose.exchange.models.acceptance import require_plausible
from truepose.exchange.programs.correction_request import CorrectionRequest
from truepose.exchange.programs.program import TargetConventions
from truepose.exchange.tables.targets import CorrectionWriter
from truepose.kinematics.inverse import BRANCH_NAMES
from truepose.messages.catalogue import english
from truepose.messages.message import Message
from truepose.notebook import display
from truepose.notebook.display import frame
from truepose.notebook.inputs import TableOrFile, named_data, on_one_thread
from truepose.notebook.model import Model, model_given
from truepose.reports.correction import correction_sentences

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, repr=False)
class Corrections:
    """Joint targets that make the real tool arrive; n targets of J joints.

    Attributes
    ----------
    names : tuple of str
        Of the targets, in their order.
    found : truepose.correction.Corrections
        Joints in rad, errors, uncertainties and status of every target.
    remarks : tuple of str
        How many were corrected and how well, what was ignored in the table, what the model leaves out.

    Examples
    --------
    >>> import truepose as tp
    >>> model = tp.identify(tp.read_campaign("docs/examples/campaign")).model
    >>> pose = {"position_mm": [[350.0, 100.0, 400.0]], "qw": 0.0, "qx": 0.0, "qy": 1.0, "qz": 0.0}
    >>> corrected = tp.correct(model, pose)
    >>> corrected.joints_deg.shape, corrected.solved.tolist()
    ((1, 6), [True])
    """

    names: tuple[str, ...]
    found: Found
    remarks: tuple[str, ...]

    @property
    def solved(self) -> BoolArray:
        """Which targets were corrected, shape (n,)."""
        return self.found.solved

    @property
    def status(self) -> list[str]:
        """Of each target `ok`, `limits_unknown`, or why not: `joint_limit`, `out_of_reach`, `singular`."""
        return [str(status) for status in self.found.status]

    @property
    def joints_deg(self) -> FloatArray:
        """What to send to the controller [deg], shape (n, J); NaN where a target was not corrected."""
        return np.degrees(self.found.joints_rad)

    @property
    def standard_uncertainty_mm(self) -> FloatArray:
        """Of where the tool will really be, per axis, shape (n,)."""
        return self.found.uncertainty_mm

    def to_frame(self) -> DataFrame:
        """Return one row per target: `target, branch, q1_deg.., error_mm, u_mm, status`.

        Raises MissingExtraError where pandas is not installed.
        """
        joints = {f"q{k}_deg": angles for k, angles in enumerate(self.joints_deg.T, start=1)}
        return frame({
            "target": list(self.names),
            "branch": [BRANCH_NAMES[k] if k >= 0 else "" for k in self.found.branch.tolist()],
            **joints,
            "error_mm": self.found.error_mm,
            "u_mm": self.found.uncertainty_mm,
            "status": self.status,
        })

    def save(self, file: str | Path) -> None:
        """Write the rows as CSV, as `truepose correct --out` does; raises OSError."""
        with Path(file).open("w", encoding="utf-8", newline="\n") as stream:
            CorrectionWriter(stream).write(self.names, self.found)

    def __repr__(self) -> str:
        return self.remarks[0]

    def _repr_html_(self) -> str:
        joints = range(1, self.found.joints_rad.shape[1] + 1)
        rows = [
            (name, status, *(f"{angle:.4f}" for angle in angles), f"{u:.4f}")
            for name, status, angles, u in zip(
                self.names, self.status, self.joints_deg.tolist(), self.found.uncertainty_mm, strict=True
            )
        ]
        head = ("target", "status", *(f"q{k}, deg" for k in joints), "u, mm")
        return display.page(display.paragraphs(self.remarks), display.first_rows(head, rows))


@on_one_thread
def correct(
    model: Model | str | Path,
    targets: TableOrFile,
    *,
    frame: Literal["world", "base"] = "world",
    max_shift_mm: float | None = None,
    as_written: bool = False,
) -> Corrections:
    """Find joint targets at which the real tool is where it shall be.

    Parameters
    ----------
    model : Model or path
    targets : table or path
        n rows of `x_mm, y_mm, z_mm, qw, qx, qy, qz`: position and orientation of the flange frame, or with a
        `nest` the position of that nest. Optional: `target` (a name), `branch` (`front/up/no flip`), joint
        angles near which the answer shall be (`q1_deg`.. or `joints_deg`), `dir1`.., `temperature_C`. Or
        joint angles alone: what the controller itself would be sent to.
    frame : {"world", "base"}
        What targets are given in: the frame of the readings, or the robot's own base.
    max_shift_mm : float, optional
        Largest shift of the tool by the model that is accepted; by default 5 mm.
    as_written : bool
        Whether to correct targets also where another unit or frame fits them better, or nearly all of them
        are out of reach.

    Returns
    -------
    Corrections

    Raises
    ------
    InputFileError
        The table cannot be used: with file and line, or row (from 0), and column.
    ImplausibleModelError
        The model moves the tool further than is accepted, or has values far from their priors.
    ConfigurationError
        The model needs measured joint torques that the rows do not give; or targets are not meant as they
        are written, and `as_written` does not say so.

    Examples
    --------
    >>> import truepose as tp
    >>> model = tp.identify(tp.read_campaign("docs/examples/campaign")).model
    >>> far = {"position_mm": [[2500.0, 0.0, 0.0]], "qw": 1.0, "qx": 0.0, "qy": 0.0, "qz": 0.0}
    >>> tp.correct(model, far).status
    ['out_of_reach']
    """
    data = model_given(model).data
    require_plausible(data, "model", max_shift_mm)
    names: list[str] = []
    parts: list[Found] = []
    cautions: tuple[Message, ...] = ()
    summary = Summary()
    for part, rows in corrected_rows(
        data, *named_data(targets, "targets"), CorrectionRequest(TargetConventions(frame))
    ):
        if not parts:
            cautions = table_cautions(data, part, rows, TargetConventions(frame))
        names += rows.names
        parts.append(rows.found)
        summary.add(rows.names, rows.found)
    withheld = None if as_written else reason_to_withhold(cautions, summary.totals)
    if withheld:
        raise ConfigurationError(" ".join(map(english, (*cautions[:1], withheld))))
    sentences = (*correction_sentences(summary.totals), *cautions)
    return Corrections(tuple(names), stack_tables(parts), tuple(map(english, sentences)))
