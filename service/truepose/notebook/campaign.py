"""A campaign in a notebook: from a folder, a zip, or tables in memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args, overload

import numpy as np

from truepose.domain import campaign as domain
from truepose.domain.errors import ConfigurationError
from truepose.effects.registry import unusable_causes
from truepose.exchange.campaigns.folder import campaign_files, campaign_from_arrays, write_campaign
from truepose.exchange.campaigns.zip_file import read_campaign_at
from truepose.exchange.tables.table_reader import Arrays
from truepose.messages.catalogue import english
from truepose.messages.message import Message
from truepose.notebook import display
from truepose.notebook.display import frame_of_text
from truepose.notebook.inputs import (
    RobotGiven,
    Table,
    columns_of,
    known_robot,
    read_if_path,
    readings_given,
    robot_keys,
    with_limits_of,
)

if TYPE_CHECKING:
    from pandas import DataFrame

Role = Literal[
    "calibration", "validation", "reference", "legs", "validation_legs", "fixture", "setup", "cups",
    "contacts", "validation_contacts", "targets", "target_distances",
]  # fmt: skip
Vector = Sequence[float]
_WORDS: dict[Role, str] = {
    "calibration": "calibration points",
    "validation": "validation points",
    "legs": "calibration lengths",
    "validation_legs": "validation lengths",
    "contacts": "calibration contacts",
    "validation_contacts": "validation contacts",
    "reference": "reference readings",
}
_ROLES_BY_COLUMN: dict[str, tuple[Role, Role]] = {
    "length_mm": ("legs", "validation_legs"),
    "reading_mm": ("contacts", "validation_contacts"),
}


@dataclass(frozen=True, slots=True, repr=False)
class Campaign:
    """One robot measured with one set-up: its readings, and what is known beforehand.

    Attributes
    ----------
    data : truepose.domain.campaign.Campaign
        The tables as arrays, angles in rad: `data.calibration.position_mm` has the shape (n, 3),
        `data.calibration.stops.joints_rad` (n, J).

    Examples
    --------
    >>> import truepose as tp
    >>> campaign = tp.read_campaign("docs/examples/campaign")
    >>> campaign
    Campaign of ABB IRB 120, simulated: 6 joints, 3 nests; 30 calibration points, 20 validation points
    >>> campaign.data.calibration.position_mm.shape
    (30, 3)
    """

    data: domain.Campaign

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was not understood and is ignored, and which installed causes cannot be used, as sentences."""
        return (*map(english, self.data.ignored), *unusable_causes())

    def to_frame(self, role: Role = "calibration") -> DataFrame:
        """Return one table as a DataFrame with the columns of the file format, angles in deg.

        Raises
        ------
        ConfigurationError
            The campaign has no such table.
        MissingExtraError
            pandas is not installed.
        """
        files = campaign_files(self.data)
        if f"{role}.csv" not in files:
            there = ", ".join(name.removesuffix(".csv") for name in files if name.endswith(".csv"))
            raise ConfigurationError(f"The campaign has no table {role!r}; it has {there}.")
        return frame_of_text(files[f"{role}.csv"])

    def save(self, folder: str | Path) -> None:
        """Write the campaign as a folder that the command line reads; raises OSError."""
        write_campaign(self.data, Path(folder))

    def _roles(self) -> Iterator[Role]:
        yield from (role for role in _WORDS if getattr(self.data, role) is not None)

    def _counts(self) -> Iterator[str]:
        for role in self._roles():
            yield f"{len(getattr(self.data, role))} {_WORDS[role]}"

    def __repr__(self) -> str:
        robot, nests = self.data.robot, len(self.data.nests)
        size = f"{robot.n_joints} joints, {nests} nest{'s' if nests > 1 else ''}"
        return f"Campaign of {robot.name}: {size}; {', '.join(self._counts())}"

    def _repr_html_(self) -> str:
        return display.page(display.paragraphs((repr(self), *self.data.notes, *self.remarks)))


@overload
def read_campaign(source: str | Path) -> Campaign: ...


@overload
def read_campaign(
    source: Table,
    *,
    robot: RobotGiven,
    validation: Table | None = None,
    nests_mm: Sequence[Vector | None] | None = None,
    nest_u_mm: float | Sequence[float | None] | None = None,
    base: Mapping[str, float] | None = None,
    repeatability_mm: float | None = None,
    tables: Mapping[Role, Table] | None = None,
    keys: Mapping[str, object] | None = None,
) -> Campaign: ...


def read_campaign(
    source: str | Path | Table,
    *,
    robot: RobotGiven | None = None,
    validation: Table | None = None,
    nests_mm: Sequence[Vector | None] | None = None,
    nest_u_mm: float | Sequence[float | None] | None = None,
    base: Mapping[str, float] | None = None,
    repeatability_mm: float | None = None,
    tables: Mapping[Role, Table] | None = None,
    keys: Mapping[str, object] | None = None,
) -> Campaign:
    """Read a campaign: a folder, the zip of one, or tables that are in memory.

    Parameters
    ----------
    source : path, or table
        A campaign folder or zip; all else comes from its `campaign.json` then. Or the readings to calibrate
        with: a DataFrame, a mapping of names to arrays, or a structured array. Its columns are those of the
        file format, shape (n,): `config`, `q1_deg`.. (or `q1_rad`..), `nest`, `x_mm`, `y_mm`, `z_mm`,
        `u_mm` (standard uncertainty per axis), and what else is known of a stop. In a mapping a single value
        holds for every row, and blocks stand for columns: `joints_deg` or `joints_rad` (n, J),
        `position_mm` (n, 3), `dir` (n, J), `tau_Nm` (n, J). Columns of legs make it a campaign of lengths,
        those of contacts (`target`, `reading_mm`) a closed loop, whose `targets` are then among `tables`.
    robot : str, path or table
        Name of a shipped robot, a file of one's own (`.toml`, `.urdf`), or one row per joint of the table of
        Denavit and Hartenberg (modified, after Craig): `alpha_deg`, `a_mm`, `theta_offset_deg`, `d_mm`, and
        `sign` where a joint counts the other way.
    validation : table, optional
        Readings that judge and are never used to identify, shape and columns as above.
    nests_mm : sequence of 3 numbers or None, optional
        Centres of the tool nests in the last joint's frame [mm], None for one that is unknown. Without it all
        are unknown, and found from the readings.
    nest_u_mm : float or sequence of float, optional
        Standard uncertainty of these centres per axis [mm].
    base : mapping, optional
        Nominal place of the robot in the frame of the readings: `x_mm`, `y_mm`, `z_mm`, `rx_deg`, `ry_deg`,
        `rz_deg`. Without it the base is found from the readings.
    repeatability_mm : float, optional
        Standard deviation of the arm itself per axis [mm]; by default that of the shipped robot.
    tables : mapping of role to table, optional
        Further tables by their role in the file format: `reference`, `fixture`, `setup`, `cups`, `targets`,
        `target_distances`.
    keys : mapping, optional
        Further keys of `campaign.json`, such as `masses` or `tracker_position_world_mm`. The masses of a
        shipped robot contain the tool that it was measured with; give your own.

    Returns
    -------
    Campaign

    Raises
    ------
    InputFileError
        With file, line and column, or for tables with name, row (from 0) and column, in one sentence.
    UnknownRobotError
        No shipped robot has that name; the sentence lists those that there are.
    ConfigurationError
        Arguments that do not go together.

    Examples
    --------
    >>> import truepose as tp
    >>> tp.read_campaign("docs/examples/campaign")
    Campaign of ABB IRB 120, simulated: 6 joints, 3 nests; 30 calibration points, 20 validation points

    Columns may as well come from arrays, or from a DataFrame with the same names:

    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> readings = {
    ...     "config": np.arange(40),
    ...     "joints_rad": rng.uniform(-1.0, 1.0, (40, 6)),
    ...     "nest": 1,
    ...     "position_mm": rng.uniform(300.0, 600.0, (40, 3)),
    ...     "u_mm": 0.015,
    ... }
    >>> tp.read_campaign(readings, robot="abb-irb-120")
    Campaign of ABB IRB 120: 6 joints, 1 nest; 40 calibration points
    >>> tp.read_campaign(readings | {"u_mm": -0.015}, robot="abb-irb-120")
    Traceback (most recent call last):
    ...
    truepose.exchange.errors.BadValueError: calibration, row 0, column u_mm: '-0.015' must be greater than 0.
    """
    if isinstance(source, str | Path):
        return Campaign(read_campaign_at(Path(source)))
    if robot is None:
        raise ConfigurationError(
            "Readings need a robot: give robot=..., the name of a shipped robot or the rows of its table."
        )
    roles, remarks = _arrays(source, validation, tables or {})
    found = known_robot(robot)
    described = {
        **robot_keys(robot, found),
        "tool_nests_mm": _centres(nests_mm, roles),
        "tool_nest_u_mm": _plain(nest_u_mm),
        "base_in_world_nominal": base,
        **({} if repeatability_mm is None else {"robot_repeatability_mm": repeatability_mm}),
        **{key: _plain(value) for key, value in (keys or {}).items()},
    }
    campaign = with_limits_of(campaign_from_arrays(described, roles), found)
    return Campaign(replace(campaign, ignored=(*remarks, *campaign.ignored)))


def campaign_given(given: Campaign | str | Path) -> Campaign:
    """Return a campaign, read first where a path is given; raises ConfigurationError, InputFileError."""
    advice = "give a folder, or create a campaign with tp.read_campaign(readings, robot=...)"
    return read_if_path(given, Campaign, read_campaign, advice)


def _arrays(
    source: Table, validation: Table | None, tables: Mapping[Role, Table]
) -> tuple[dict[str, Arrays], tuple[Message, ...]]:
    """Return the tables by role, and what their columns were taken for.

    Lengths and readings without positions are legs and contacts.
    """
    given, remarks = _readings(source, "calibration")
    told = (own for column, own in _ROLES_BY_COLUMN.items() if column in given and "x_mm" not in given)
    first, held_out = next(told, ("calibration", "validation"))
    roles: dict[str, Arrays] = {first: given}
    if validation is not None:
        roles[held_out], more = _readings(validation, held_out)
        remarks += more
    for role, table in tables.items():
        roles[_known(role)] = columns_of(table, role)
    return roles, remarks


def _readings(given: Table, name: str) -> tuple[Arrays, tuple[Message, ...]]:
    table = readings_given(given, name)
    return (columns_of(given, name) if table.imported is None else table.imported.columns), table.remarks


def _known(role: Role) -> Role:
    known = get_args(Role)
    if role not in known:
        raise ConfigurationError(f"A campaign has no table {role!r}; known tables: {', '.join(known)}.")
    return role


def _centres(nests_mm: Sequence[Vector | None] | None, roles: Mapping[str, Arrays]) -> list[object]:
    """Return the centres of the nests; where none is stated, as many unknown ones as the readings name."""
    if nests_mm is not None:
        return [_plain(centre) for centre in nests_mm]
    named = [
        columns[name]
        for columns in roles.values()
        for name in ("nest", "tool_point")
        if name in columns and columns[name].dtype.kind == "f" and columns[name].size
    ]
    most = max((float(np.nanmax(column)) for column in named), default=1.0)
    return [None] * max(1, int(most))


def _plain(value: object) -> object:
    """Return a value as a JSON document would have it: lists and Python's own numbers."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(entry) for entry in value]
    return value
