"""Plans of tracker sessions in a notebook."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.session import SessionPlan
from truepose.exchange.cells.file import read_cell
from truepose.exchange.tables.stops import NO_REPEAT, joint_names
from truepose.notebook import html
from truepose.notebook.frames import frame
from truepose.notebook.given import path_of
from truepose.notebook.wording import counted
from truepose.planning.tracker.session_plans import plan_session
from truepose.planning.work_volume.cell_space import space_to_measure

if TYPE_CHECKING:
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

    def to_frame(self) -> "DataFrame":
        """Return one row per stop: `config, q1_deg.., nest, repeat_of`, as a service takes them.

        Raises
        ------
        MissingExtraError
            pandas is not installed.
        """
        joints = dict(zip(joint_names(self.joints_rad.shape[1]), np.degrees(self.joints_rad).T, strict=True))
        return frame({"config": self.config, **joints, "nest": self.nest, "repeat_of": self.repeat_of})

    def __repr__(self) -> str:
        again = int((self.repeat_of != NO_REPEAT).sum())
        stops = counted(len(self.config) - again, "configuration")
        return f"Plan of a {self.role} of {self.robot}: {stops}, {counted(again, 'revisit')}"

    def _repr_html_(self) -> str:
        names = [f"q{joint}, deg" for joint in range(1, self.joints_rad.shape[1] + 1)]
        rows = [
            (str(config), *(f"{angle:.2f}" for angle in angles), str(nest))
            for config, angles, nest in zip(
                self.config, np.degrees(self.joints_rad).tolist(), self.nest, strict=True
            )
        ]
        return html.page(html.paragraphs([repr(self)]), html.first_rows(("config", *names, "nest"), rows))


def plan(
    cell: str | Path,
    n: int,
    role: Literal["calibration", "validation"] = "calibration",
    *,
    seed: int = 0,
    approach_deg: float | None = -5.0,
) -> Plan:
    """Choose the configurations of a tracker session in a cell, as the service does; nothing moves.

    To calibrate they are chosen by observability and some are revisited at the end; to validate they are
    drawn at random. All are within the joint ranges of the cell, clear of table and column, and in sight of
    the tracker.

    Parameters
    ----------
    cell : path
        Cell file (TOML), as `truepose serve --cell` takes it.
    n : int
        Different configurations; the revisits come on top.
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
    Plan of a validation of ABB IRB 120: 10 configurations, no revisit
    """
    if n < 1:
        raise ConfigurationError(f"n is {n}: ask for one configuration at least.")
    described = read_cell(path_of(cell, "cell file", "give the path of one (TOML), as truepose serve --cell"))
    offset_rad = None if approach_deg is None else math.radians(approach_deg)
    template = SessionPlan(role, (), approach_offset_rad=offset_rad)
    stops = plan_session(space_to_measure(described, offset_rad), template, n, seed).stops
    return Plan(
        described.robot.name,
        role,
        np.array([stop.config for stop in stops]),
        np.array([stop.joints_rad for stop in stops]),
        np.array([stop.nest for stop in stops]),
        np.array([NO_REPEAT if stop.repeat_of is None else stop.repeat_of for stop in stops]),
    )
