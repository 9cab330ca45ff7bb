"""A measured campaign once more, in the cell: the same stops, times and circumstances, simulated readings.

A model that looked at their readings states by how much each was off its certificate, `fixed_<nest>_x`..
[mm], and by which small motion about the world's origin the world was registered wrong, `frame_x`..`frame_rz`
[mm, rad]; the motion comes after the offset.

The readings are in the world of the model, whose base already holds how the measured world was registered;
the tracker is not registered anew. Their noise is what the campaign states of each reading, and the arm's
scatter what the model states of the arm.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ReplayError
from truepose_simulators.instruments.tracker import in_tracker_frame
from truepose_simulators.instruments.truth_endpoint import plant_document
from truepose_simulators.physics.effects import Conditions, IdentifiedEffect
from truepose_simulators.physics.effects.effect import COMPONENTS
from truepose_simulators.physics.effects.thermal_growth import LENGTHS_HOLD_C
from truepose_simulators.physics.identified import IdentifiedModel
from truepose_simulators.physics.rigid import FloatArray, motion, move, pose_matrix, small_motion
from truepose_simulators.recording.files import write_json, write_table
from truepose_simulators.recording.measured_campaign import (
    POINTS,
    MeasuredTable,
    certified_nests_mm,
    read_description,
    read_table,
    tracker_files,
)

_COVARIANCE = (("cxx", "cxy", "cxz"), ("cxy", "cyy", "cyz"), ("cxz", "cyz", "czz"))  # mm2


def draw_noise(
    table: MeasuredTable, position_mm: FloatArray, instrument_mm: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Draw noise for readings at positions (n, 3) by an instrument at a place (3,), shape (n, 3) [mm]."""
    values, axes = np.linalg.eigh(stated_covariance(table, position_mm, instrument_mm))
    along_axes = np.sqrt(np.maximum(values, 0.0)) * rng.standard_normal(position_mm.shape)
    noise: FloatArray = np.einsum("nij,nj->ni", axes, along_axes)
    return noise


def stated_covariance(table: MeasuredTable, position_mm: FloatArray, instrument_mm: FloatArray) -> FloatArray:
    """Covariance of every reading, shape (n, 3, 3) [mm2]; the most detailed statement of a row counts."""
    covariance = _variance(table.known("u_mm"), np.eye(3))
    if "u_along_mm" in table and "u_across_mm" in table:
        along, across = table.numbers("u_along_mm"), table.numbers("u_across_mm")
        beam = position_mm - instrument_mm
        beam = beam / np.linalg.norm(beam, axis=1, keepdims=True)
        projector = beam[:, :, np.newaxis] * beam[:, np.newaxis, :]
        on_beam = _variance(along, projector) + _variance(across, np.eye(3) - projector)
        covariance = _where_stated(on_beam, covariance)
    if all(name in table for row in _COVARIANCE for name in row):
        full = np.array([[table.numbers(name) for name in row] for row in _COVARIANCE])
        covariance = _where_stated(np.moveaxis(full, 2, 0), covariance)
    return covariance


def _variance(u_mm: FloatArray, shape: FloatArray) -> FloatArray:
    variance: FloatArray = u_mm[:, np.newaxis, np.newaxis] ** 2 * shape
    return variance


def _where_stated(detailed: FloatArray, plain: FloatArray) -> FloatArray:
    stated = np.isfinite(detailed).all(axis=(1, 2), keepdims=True)
    return np.where(stated, detailed, plain)


_EFFECT = "reference"
_FORM = "fixed_<nest>_x, _y, _z, frame_x to frame_rz"


def places_of_fixed_nests(
    table: MeasuredTable, certified_mm: FloatArray, model: IdentifiedModel
) -> FloatArray:
    """Place of the fixed nest in every row, shape (n, 3) [mm, world], before the instrument sees it.

    Nests without a certificate, of which `certified_mm` (k, 3) has none, are where they were read on average.
    """
    nest = table.known("fixed_nest")
    read = np.stack([table.known(f"{axis}_mm") for axis in "xyz"], axis=1)
    frame, offsets = _stated(model)
    places = np.empty_like(read)
    for number in np.unique(nest):
        here = nest == number
        places[here] = read[here].mean(axis=0)
        if 1 <= number <= len(certified_mm):
            offset = offsets.get(int(number), np.zeros(3))
            places[here] = move(pose_matrix(frame[:3], frame[3:]), certified_mm[int(number) - 1] + offset)
    return places


def _stated(model: IdentifiedModel) -> tuple[FloatArray, dict[int, FloatArray]]:
    """Return the six components of the registration's error and the offset of every nest."""
    frame = np.zeros(6)
    offsets: dict[int, FloatArray] = {}
    stated = IdentifiedEffect(_EFFECT, model.parameters.get(_EFFECT, {}))
    pattern = r"(?:fixed_([0-9]+)_([xyz])|frame_(r?[xyz]))"
    for (nest, axis, component), value in stated.matching(pattern, _FORM):
        if nest is None:
            frame[COMPONENTS.index(component)] = value
        else:
            offsets.setdefault(int(nest), np.zeros(3))["xyz".index(axis)] = value
    return frame, offsets


# What this tracker, which measures points, does not read.
_ORIENTATION = ("qw", "qx", "qy", "qz", "u_rot_deg")
# The column without which an effect does not act: the arm stands in the middle, or at the origin of times.
_ACTS_BY = {
    "backlash": "dir1",
    "base_drift": "time_s",
    "base_shift": "time_s",
    "instrument_drift": "time_s",
    "thermal_growth": "temperature_C",
    "tool_reseating": "attachment",
}


@dataclass(frozen=True, slots=True)
class Replay:
    """A replayed campaign."""

    cell: Cell
    document: Mapping[str, Any]  # campaign.json
    tables: Mapping[str, MeasuredTable]  # by role
    true_mm: Mapping[str, FloatArray]  # by role, (n, 3) without noise and scatter
    remarks: tuple[str, ...]  # effects that could not act, one sentence each


def replay(cell: Cell, model: IdentifiedModel, folder: Path) -> Replay:
    """Replay the campaign of a folder in a cell that holds the model; raises ReplayError."""
    document = read_description(folder)
    files = tracker_files(document)
    tracker = _Tracker(cell, model, document)
    tables, true_mm, remarks = {}, {}, []
    for role, name in files.items():
        table = read_table(folder / name)
        remarks += _remarks(table, model) if role in POINTS else []
        true_mm[role] = (
            _true_points(cell, model, table, tracker)
            if role in POINTS
            else places_of_fixed_nests(table, certified_nests_mm(document), model)
        )
        tables[role] = table.with_positions(tracker.read(table, true_mm[role], role), _ORIENTATION)
    return Replay(cell, _noted(document, model, files), tables, true_mm, tuple(remarks))


def write_replay(replayed: Replay, folder: Path) -> None:
    """Write the replayed campaign as a folder, which may exist, with the truth beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    for table in replayed.tables.values():
        write_table(folder / table.name, table.columns)
    truth = {role: true_mm.tolist() for role, true_mm in replayed.true_mm.items()}
    write_json(folder / "campaign.json", replayed.document)
    write_json(folder / "truth.json", {**plant_document(replayed.cell), "true_positions_mm": truth})


class _Tracker:
    """Reads points of the model's world at times of the campaign."""

    def __init__(self, cell: Cell, model: IdentifiedModel, document: Mapping[str, Any]) -> None:
        self._cell = cell
        self._origin_s = model.origin_s
        # Where no place is stated, lengths are off about the origin, as the model has it.
        place = np.zeros(3) if model.instrument_mm is None else np.array(model.instrument_mm)
        self._frame = motion(place, np.eye(3))
        self._scatter_mm = 0.0 if document.get("u_includes_repeatability") else model.repeatability_mm

    def elapsed_s(self, table: MeasuredTable) -> FloatArray:
        """Cell time of every row, shape (n,)."""
        return table.or_else("time_s", self._origin_s) - self._origin_s

    def read(self, table: MeasuredTable, true_mm: FloatArray, role: str) -> FloatArray:
        """Read points (n, 3) of the world, in the world."""
        time_s, cell = self.elapsed_s(table), self._cell
        scattered = true_mm
        if cell.noise is not None and role in POINTS:
            _, stop = np.unique(table.known("config"), return_inverse=True)
            # One draw a stop: all readings of a stop are of one arm at rest.
            scattered = true_mm + self._scatter_mm * cell.noise.standard_normal((stop.max() + 1, 3))[stop]
        frames = small_motion(cell.planted.frame_motion(time_s)) @ self._frame
        read = move(self._frame, cell.spoiled(in_tracker_frame(frames, scattered), time_s))
        if cell.noise is None:
            return read
        return read + draw_noise(table, read, self._frame[:3, 3], cell.noise)


def _true_points(cell: Cell, model: IdentifiedModel, table: MeasuredTable, tracker: _Tracker) -> FloatArray:
    conditions = _conditions(model, table, tracker.elapsed_s(table))
    nest = cell.nests_read(_nests(table, len(cell.tool_nests_mm)), conditions.time_s)
    positions: FloatArray = cell.true_positions(conditions)[np.arange(len(table)), nest - 1]
    return positions


def _conditions(model: IdentifiedModel, table: MeasuredTable, time_s: FloatArray) -> Conditions:
    n_joints = len(model.table.rows)
    directions = [table.or_else(f"dir{joint}", 0.0) for joint in range(1, n_joints + 1)]
    return Conditions(
        joints_rad=np.radians(table.per_joint("q{}_deg", n_joints)),
        direction=np.stack(directions, axis=1),
        time_s=time_s,
        temperature_c=table.or_else("temperature_C", LENGTHS_HOLD_C),
        attachment=table.or_else("attachment", 0.0),
        measured_torque_n_mm=_sensed_torques_n_mm(model, table, n_joints),
    )


def _sensed_torques_n_mm(model: IdentifiedModel, table: MeasuredTable, n_joints: int) -> FloatArray | None:
    if not model.sensed_torques:
        return None
    # A campaign without torques can be replayed where masses are known: gravity loads the gearboxes then.
    if "tau1_Nm" not in table and model.table.masses:
        return None
    return 1000.0 * table.per_joint("tau{}_Nm", n_joints)


def _nests(table: MeasuredTable, count: int) -> Any:
    nest = table.known("nest")
    wrong = (nest < 1) | (nest > count) | (nest != np.round(nest))
    if wrong.any():
        row = int(np.argmax(wrong))
        raise ReplayError(
            f"{table.name}, line {row + 2}: the model has nests 1 to {count}, not {nest[row]:g}"
        )
    return nest.astype(int)


def _remarks(table: MeasuredTable, model: IdentifiedModel) -> list[str]:
    return [
        f"{table.name} has no column {column}: {effect} does not act in its rows"
        for effect, column in _ACTS_BY.items()
        if effect in model.parameters and column not in table
    ]


def _noted(document: Mapping[str, Any], model: IdentifiedModel, files: Mapping[str, str]) -> dict[str, Any]:
    notes = document.get("notes")
    note = f"Replayed in the simulated cell with the identified model of {model.table.name}."
    kept = {key: value for key, value in document.items() if key != "measured_on"}  # that day saw others
    return {
        **kept,
        "simulated": True,
        "files": dict(files),
        "notes": [*(notes if isinstance(notes, list) else []), note],
    }
