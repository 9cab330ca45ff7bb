"""A cell by whatever name somebody gives it: a cell file, a robot file, a shipped robot, a scenario."""

from pathlib import Path

from truepose.domain.cell.description import Cell
from truepose.exchange.cells.file import SCENARIO_PREFIXES, cell_on_usual_table, read_cell, simulated_cell
from truepose.exchange.document import toml_document
from truepose.exchange.errors import UnknownRobotError
from truepose.exchange.input_file import read_bytes
from truepose.exchange.robots.files import is_robot_file
from truepose.exchange.robots.shipped import list_robots

_OF_ROBOTS = "dhm_nominal"  # a key that robot files have, and cell files have not


def cell_given(given: str) -> Cell:
    """Return the cell of a cell file (TOML), or that of a robot, its file or a scenario on the usual table.

    Raises
    ------
    UnknownRobotError
        It is neither a file nor a name that is known.
    InputFileError
        The file cannot be used.
    """
    path = Path(given)
    if path.suffix.lower() == ".toml":
        described = _OF_ROBOTS in toml_document(path.name, read_bytes(path)).entries()
        return cell_on_usual_table(given) if described else read_cell(path)
    if given in list_robots() or is_robot_file(given):
        return cell_on_usual_table(given)
    if given.startswith(SCENARIO_PREFIXES):
        return simulated_cell(given, 0)
    raise UnknownRobotError(
        f"{given!r} is no campaign folder, no file of a cell or robot, and no robot; the shipped robots are "
        f"{', '.join(list_robots())}."
    )
