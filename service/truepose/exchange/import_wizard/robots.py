"""Which robot the readings are of: the one that somebody says, a file describes, or a known one that fits."""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Robot
from truepose.exchange.campaigns.description import described_robot
from truepose.exchange.document import json_document
from truepose.exchange.import_wizard.columns import Cells, ImportedTable
from truepose.exchange.import_wizard.dialogue import OWN_ROBOT, ChangeOffered, Choices, RobotSeen
from truepose.exchange.import_wizard.files import Piece
from truepose.exchange.import_wizard.tables import (
    has_positions,
    joints_of,
    n_joints,
    positions_of,
    whole_or_0,
)
from truepose.exchange.robots.named import list_robots, load_robot, read_robot_file
from truepose.identification.problem.initial_frames import PriorPlacement
from truepose.identification.verdict.conventions import Change, Evidence, Interpretation
from truepose.identification.verdict.robot_match import Match, matches
from truepose.messages.message import Message, Text, message

# Of the arm: base and reflector alone fit as many numbers as two or three places give.
_FEWEST_PLACES: Final = 10
_SWAPPED: Final = ("dir{}", "tau{}_Nm")
_OF_THE_ROBOT: Final = frozenset({"other_way", "zero"})  # changes of its table, and of no reading


@dataclass(frozen=True, slots=True)
class Found:
    """The robot of a campaign, as it was described, and what is shown of it."""

    robot: Robot | None
    seen: RobotSeen | None
    question: Message | None = None


def robot_of(pieces: Sequence[Piece], table: ImportedTable, choices: Choices) -> Found:
    """Return the robot of readings; raises InputFileError where a file describes none."""
    own = _own_robot(pieces)
    chosen = _chosen(own, choices)
    if chosen is None:
        tells = has_positions(table.columns) and _places(table) >= _FEWEST_PLACES
        return _found(table, choices) if tells else Found(None, None, message("bring.ask.robot"))
    key, robot, reason = chosen
    if robot.n_joints != n_joints(table.columns):
        asked = message(
            "bring.ask.joints_differ", robot=robot.name, own=robot.n_joints, seen=n_joints(table.columns)
        )
        return Found(robot, RobotSeen(key, robot.name, reason, fits=False), asked)
    if not has_positions(table.columns):
        return Found(robot, RobotSeen(key, robot.name, reason, fits=True))
    return _judged(key, robot, reason, table, choices)


def _chosen(own: Robot | None, choices: Choices) -> tuple[str, Robot, Message] | None:
    # A robot that somebody brought is meant; the known ones are for whoever brought none.
    if own is not None and choices.robot in {None, OWN_ROBOT}:
        return OWN_ROBOT, own, message("bring.robot.file")
    if choices.robot in list_robots() and choices.robot is not None:
        return choices.robot, load_robot(choices.robot), message("bring.robot.said")
    return None


def _own_robot(pieces: Sequence[Piece]) -> Robot | None:
    for piece in pieces:
        if piece.kind == "robot":
            return _read(piece)
    for piece in pieces:
        if piece.kind == "description":
            root = json_document(piece.name, piece.data)
            return described_robot(root) if "dhm_nominal" in root.entries() else None
    return None


def _read(piece: Piece) -> Robot:
    """Return the robot of a file; its readers take a path."""
    with tempfile.TemporaryDirectory() as folder:
        # Named here: what somebody called a file is no path.
        path = Path(folder) / f"robot{Path(piece.name).suffix.lower()}"
        path.write_bytes(piece.data)
        return read_robot_file(path).robot


def _places(table: ImportedTable) -> int:
    return len(np.unique(np.round(joints_of(table.columns), 2), axis=0))


def _found(table: ImportedTable, choices: Choices) -> Found:
    """Return the known robot that fits, and the question where none does."""
    known = {load_robot(name): name for name in list_robots()}
    evidence, nests = evidence_of(table, choices.changes)
    tried = matches(tuple(known), evidence, nests)
    if not tried:
        return Found(None, None, message("bring.ask.robot_unknown", joints=n_joints(table.columns)))
    best = tried[0]
    if not best.fits:
        names = tuple(robot.name for robot in known)
        asked = message(
            "bring.ask.none_fits", robots=names, nearest=best.robot.name, typical_mm=best.typical_mm
        )
        return Found(None, None, asked)
    reason = message("bring.robot.found", tried=len(tried), typical_mm=best.typical_mm)
    return _shown(known[best.robot], best, reason)


def _judged(key: str, robot: Robot, reason: Text, table: ImportedTable, choices: Choices) -> Found:
    evidence, nests = evidence_of(table, ())
    meant = _applied(Interpretation(robot, evidence), choices.changes)
    (held,) = matches((meant.robot,), meant.evidence, nests)
    return replace(_shown(key, held, reason), robot=robot)


def _shown(key: str, held: Match, reason: Text) -> Found:
    offered = tuple(
        ChangeOffered(one.sentence, one.kind, one.first, one.second, one.amount) for one in held.changes
    )
    fits = held.fits and not offered
    seen = RobotSeen(key, held.robot.name, reason, fits, held.typical_mm, offered)
    if fits:
        return Found(held.robot, seen)
    if offered:
        return Found(held.robot, seen, message("bring.ask.change", robot=held.robot.name))
    return Found(
        held.robot, seen, message("bring.ask.no_fit", robot=held.robot.name, typical_mm=held.typical_mm)
    )


def evidence_of(table: ImportedTable, changes: Sequence[Change]) -> tuple[Evidence, PriorPlacement]:
    """Return the readings that are whole, and what is known of their nests: nothing."""
    columns = table.columns
    joints_deg, places = joints_of(columns), positions_of(columns)
    nest = np.nan_to_num(columns["nest"].astype(float), nan=1.0)
    whole = np.isfinite(joints_deg).all(axis=1) & np.isfinite(places).all(axis=1)
    _, nest = np.unique(nest[whole], return_inverse=True)
    evidence = Evidence(np.radians(joints_deg[whole]), nest.reshape(-1) + 1, places[whole])
    count = int(evidence.nest.max(initial=1))
    for change in changes:
        if change.kind not in _OF_THE_ROBOT:
            evidence = change.applied(Interpretation(Robot("", ()), evidence)).evidence
    return evidence, PriorPlacement(None, np.zeros((count, 3)), np.ones(count, bool))


def _applied(meant: Interpretation, changes: Sequence[Change]) -> Interpretation:
    _require_joints(changes, meant.evidence.joints_rad.shape[1])
    for change in changes:
        meant = change.applied(meant)
    return meant


def _require_joints(changes: Sequence[Change], n_joints: int) -> None:
    """Refuse a change of a joint that the robot has not: it was made for other columns."""
    of_joints = (one for one in changes if one.kind in {"other_way", "coupled", "columns", "zero"})
    if any(max(one.first, one.second) >= n_joints for one in of_joints):
        raise ConfigurationError("A change names a joint that this robot does not have; undo the change.")


def apply_changes(
    robot: Robot, columns: Mapping[str, Cells], changes: Sequence[Change]
) -> tuple[Robot, dict[str, Cells]]:
    """Return a robot and a table as they are meant, after changes that somebody accepted."""
    found = dict(columns)
    if not changes:
        return robot, found
    count = len(next(iter(found.values())))
    positions = positions_of(found) if has_positions(found) else np.zeros((count, 3))
    nest = whole_or_0(found["nest"]) if "nest" in found else np.ones(count, np.int64)
    meant = _applied(Interpretation(robot, Evidence(np.radians(joints_of(found)), nest, positions)), changes)
    for joint, angles in enumerate(np.degrees(meant.evidence.joints_rad).T, start=1):
        found[f"q{joint}_deg"] = angles
    if has_positions(found):
        found |= {
            f"{axis}_mm": cells for axis, cells in zip("xyz", meant.evidence.position_mm.T, strict=True)
        }
    if "nest" in found:
        found["nest"] = meant.evidence.nest.astype(float)
    for change in changes:
        if change.kind == "columns":
            _exchange(found, change.first + 1, change.second + 1)
    return meant.robot, found


def _exchange(columns: dict[str, Cells], first: int, second: int) -> None:
    for form in _SWAPPED:
        one, other = form.format(first), form.format(second)
        if one in columns and other in columns:
            columns[one], columns[other] = columns[other], columns[one]
