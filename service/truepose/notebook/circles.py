"""The single-axis circle test in a notebook."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from truepose.domain.campaign import PointReadings
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Robot
from truepose.exchange.json_text import Json
from truepose.exchange.results.circles_and_spheres import circle_document
from truepose.messages.catalogue import IN_ENGLISH, english
from truepose.notebook import display
from truepose.notebook.display import count_text, frame
from truepose.notebook.inputs import TableOrFile, known_robot, on_one_thread, readings_given
from truepose.notebook.model import Model
from truepose.reports.circles import CircleReport, circle_table, circle_test_sentences
from truepose.validation.circle_test import CircleTest, circle_test

if TYPE_CHECKING:
    from pandas import DataFrame

_NESTS = range(1, 10)  # a table on its own does not say which there are


@dataclass(frozen=True, slots=True, repr=False)
class CircleErrors:
    """What each joint errs by, turned alone.

    Attributes
    ----------
    answer : truepose.validation.circle_test.CircleTest
        Circles with their errors [mm, rad], and the sweeps that give none.
    robot : str
    remarks : tuple of str
        What was ignored in the table.

    Examples
    --------
    >>> import numpy as np, truepose as tp
    >>> turn = np.radians(np.arange(-60.0, 61.0, 10.0))
    >>> readings = {"config": np.arange(13), "joints_rad": np.outer(turn, [1, 0, 0, 0, 0, 0]), "nest": 1}
    >>> readings |= {"x_mm": 400.0 * np.cos(turn), "y_mm": 400.0 * np.sin(turn), "z_mm": 290.0, "u_mm": 0.01}
    >>> (turned,) = tp.circles(readings, "abb-irb-120").answer.circles
    >>> turned.joint, turned.is_noise
    (1, True)
    """

    answer: CircleTest
    robot: str
    remarks: tuple[str, ...]

    @property
    def document(self) -> dict[str, Json]:
        """What `truepose circles --json` prints."""
        return circle_document(self.answer, self.robot).printed()

    def to_frame(self) -> DataFrame:
        """Return the errors at all stops [mm, deg], one row per stop, joint and nest.

        Raises MissingExtraError where pandas is not installed.
        """
        return frame([
            {"joint": one.joint, "nest": one.nest, **dict(zip(columns, row, strict=True))}
            for one in circle_document(self.answer, self.robot).circles
            for columns in [one.stops.model_dump()]
            for row in zip(*columns.values(), strict=True)
        ])

    def report(self, file: str | Path) -> None:
        """Write the report, as `truepose circles --report` does; raises UnwritableReportError."""
        CircleReport(self.answer, self.robot).write(Path(file))

    def __repr__(self) -> str:
        found = count_text(len(self.answer.circles), "circle")
        return f"Circle test of {self.robot}: {found}, {len(self.answer.withheld)} withheld"

    def _repr_html_(self) -> str:
        shown = circle_table(self.answer, IN_ENGLISH)
        return display.page(
            display.table("Circle test", shown.heads, shown.rows, numbers_from=2),
            display.paragraphs((*map(english, circle_test_sentences(self.answer)), *self.remarks)),
        )


@on_one_thread
def circles(points: TableOrFile, robot: Model | str | Path) -> CircleErrors:
    """Say what each joint errs by, turned alone.

    Parameters
    ----------
    points : table or path
        n readings of positions with the columns of `read_campaign`; a file is CSV.
    robot : str, path or Model
        Name of a shipped robot, a file of one's own (`.toml`, `.urdf`), or a model.

    Returns
    -------
    CircleErrors

    Raises
    ------
    InputFileError
        The table cannot be used: with file and line, or row (from 0), and column.
    ConfigurationError
        The rows hold lengths, or no joint is turned alone.

    Examples
    --------
    >>> import numpy as np, truepose as tp
    >>> turn = np.arange(-60.0, 61.0, 10.0)
    >>> readings = {
    ...     "config": np.arange(13),
    ...     "joints_deg": np.column_stack([turn, np.zeros((13, 5))]),
    ...     "nest": 1,
    ...     "x_mm": 400.0 * np.cos(np.radians(turn)),
    ...     "y_mm": 400.0 * np.sin(np.radians(turn)),
    ...     "z_mm": 290.0,
    ...     "u_mm": 0.01,
    ... }
    >>> tp.circles(readings, "abb-irb-120")
    Circle test of ABB IRB 120: 1 circle, 0 withheld
    """
    arm = _robot(robot)
    table = readings_given(points, "points").validation(arm.n_joints, _NESTS)
    if not isinstance(table.readings, PointReadings):
        raise ConfigurationError("The rows hold lengths; a circle test needs positions: x_mm, y_mm, z_mm.")
    return CircleErrors(circle_test(table.readings), arm.name, tuple(map(english, table.ignored)))


def _robot(given: Model | str | Path) -> Robot:
    found = given.data.robot if isinstance(given, Model) else known_robot(given)
    if found is None:
        raise ConfigurationError("robot: give the name of a shipped robot, a robot file, or a model.")
    return found
