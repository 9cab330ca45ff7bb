"""Plans of tracker sessions in a notebook."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.session import SessionPlan
from truepose.exchange.cells.file import cell_given
from truepose.exchange.tables.fields import NO_REPEAT, joint_names
from truepose.messages.catalogue import english
from truepose.notebook import display
from truepose.notebook.display import count_text, frame
from truepose.notebook.inputs import on_one_thread, path_of
from truepose.planning.prediction.errors import CurvePoint
from truepose.planning.prediction.plan import PromisedPlan
from truepose.planning.prediction.robots_and_cells import of_cell
from truepose.planning.prediction.tracker import promised_session
from truepose.planning.tracker.plans import plan_session
from truepose.planning.workspace.space import space_to_measure
from truepose.reports.plans import promise_sentence

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, repr=False)
class Plan:
    """Configurations to measure, in order; n stops of J joints.

    Attributes
    ----------
    config : ndarray, shape (n,)
    joints_rad : ndarray, shape (n, J)
    nest : ndarray, shape (n,)
        The tool nest that faces the tracker best, from 1.
    repeat_of : ndarray, shape (n,)
        The earlier stop that is visited once more, -1 for none.
    promise : PromisedPlan or None
        What so many configurations promise, and what more would (`curve`, `advised`, `left_open`); None of
        a validation.

    Examples
    --------
    >>> import truepose as tp
    >>> plan = tp.plan("docs/examples/networked-cell.toml", 10, role="validation", seed=1)
    >>> plan.joints_rad.shape
    (10, 6)
    """

    robot: str
    role: str
    config: IntArray
    joints_rad: FloatArray
    nest: IntArray
    repeat_of: IntArray
    promise: PromisedPlan | None

    def plot(self) -> "Figure | None":
        """Return the promised error against the number of configurations; None of a validation.

        The figure is of matplotlib and belongs to no window: change and save it as any other.
        """
        from truepose.reports.figures.curves import plain_promise_curve

        return None if self.promise is None else plain_promise_curve(self.promise)

    def curve_to_frame(self) -> "DataFrame":
        """Return one row per number of configurations: the promised errors, no rows of a validation.

        Columns `n, mean_mm, low_mm, high_mm, worst_mm, visit_mean_mm`. Raises MissingExtraError where pandas
        is not installed.
        """
        points = () if self.promise is None else self.promise.curve
        return frame([_row(point) for point in points])

    def to_frame(self) -> "DataFrame":
        """Return one row per stop: `config, q1_deg.., nest, repeat_of`, as a service takes them.

        Raises MissingExtraError where pandas is not installed.
        """
        joints = dict(zip(joint_names(self.joints_rad.shape[1]), np.degrees(self.joints_rad).T, strict=True))
        return frame({"config": self.config, **joints, "nest": self.nest, "repeat_of": self.repeat_of})

    def __repr__(self) -> str:
        again = int((self.repeat_of != NO_REPEAT).sum())
        stops = count_text(len(self.config) - again, "configuration")
        return f"Plan of a {self.role} of {self.robot}: {stops}, {count_text(again, 'repeat measurement')}"

    def _repr_html_(self) -> str:
        names = [f"q{joint}, deg" for joint in range(1, self.joints_rad.shape[1] + 1)]
        rows = [
            (str(config), *(f"{angle:.2f}" for angle in angles), str(nest))
            for config, angles, nest in zip(
                self.config, np.degrees(self.joints_rad).tolist(), self.nest, strict=True
            )
        ]
        sentences = [] if self.promise is None else [english(promise_sentence(self.promise))]
        return display.page(
            display.paragraphs([repr(self), *sentences]), display.first_rows(("config", *names, "nest"), rows)
        )


def _row(point: CurvePoint) -> dict[str, float]:
    low, high = point.interval_90_mm
    return {
        "n": point.n,
        "mean_mm": point.mean_mm,
        "low_mm": low,
        "high_mm": high,
        "worst_mm": point.worst_mm,
        "visit_mean_mm": point.visit_mean_mm,
    }


@on_one_thread
def plan(
    cell: str | Path,
    n: int | None = None,
    role: Literal["calibration", "validation"] = "calibration",
    *,
    seed: int = 0,
    approach_deg: float | None = -5.0,
) -> Plan:
    """Choose the configurations of a tracker session in a cell, as the service does; nothing moves.

    To calibrate they are chosen by observability and some are revisited at the end, and the plan says what
    accuracy that promises; to validate they are drawn at random. All are within the joint ranges of the cell,
    clear of table and column, and in sight of the tracker.

    Parameters
    ----------
    cell : path or str
        Cell file (TOML), as `truepose serve --cell` takes it; or the name of a shipped robot.
    n : int, optional
        Different configurations; the revisits come on top. To calibrate, by default as many as the knee of
        the curve of promised accuracy says.
    role : {"calibration", "validation"}
    seed : int
        The same seed gives the same plan.
    approach_deg : float or None
        Every stop is approached from there on all joints [deg]; None: in mixed directions.

    Returns
    -------
    Plan

    Raises
    ------
    InputFileError
        The cell file cannot be used.
    ConfigurationError
        Neither cell nor robot says in which ranges joints may be, `n` is below 1, or `cell` is no path.
    WorkSpaceError
        The cell does not offer that many configurations, or no ways between them.

    Examples
    --------
    >>> import truepose as tp
    >>> tp.plan("docs/examples/networked-cell.toml", 10, role="validation", seed=1)
    Plan of a validation of ABB IRB 120: 10 configurations, no repeat measurement
    """
    if n is None and role == "validation":
        raise ConfigurationError("To plan a validation, give the number of configurations, n.")
    if n is not None and n < 1:
        raise ConfigurationError(f"n must be at least 1 (got {n}).")
    advice = "give the path of a cell file (TOML), as for truepose serve --cell"
    described = cell_given(str(path_of(cell, "cell file", advice)))
    offset_rad = None if approach_deg is None else math.radians(approach_deg)
    space = space_to_measure(described, offset_rad)
    promise = None
    if role == "calibration":
        promise = promised_session(space, n, knowns=of_cell(described).knowns, seed=seed)
    many = promise.total if promise is not None else n or 0
    template = SessionPlan(role, (), approach_offset_rad=offset_rad)
    stops = plan_session(space, template, many, seed).stops
    return Plan(
        described.robot.name,
        role,
        np.array([stop.config for stop in stops]),
        np.array([stop.joints_rad for stop in stops]),
        np.array([stop.nest for stop in stops]),
        np.array([NO_REPEAT if stop.repeat_of is None else stop.repeat_of for stop in stops]),
        promise,
    )
