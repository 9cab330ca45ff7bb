"""A recording as a campaign folder: campaign.json, tables, and the truth beside them."""

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.truth_endpoint import plant_document
from truepose_simulators.physics.arm import Arm
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.recording.campaign import Points, Recording, References
from truepose_simulators.recording.nominal_tables import papers_of_cell
from truepose_simulators.scenarios.scenario import ArmSetup

Columns: TypeAlias = dict[str, list[str]]  # of a table, by name

_FORMAT = 1


def write_campaign(recording: Recording, folder: Path) -> None:
    """Write the folder, which may exist; tables that this campaign does not have are not written."""
    tables = {
        "calibration": points_table(recording.calibration),
        "validation": points_table(recording.validation),
        "reference": reference_table(recording.references),
    }
    files = write_tables(folder, tables)
    write_json(folder / "campaign.json", campaign_document(recording.cell, files))
    write_json(folder / "truth.json", truth_document(recording))


def campaign_document(cell: Cell, files: dict[str, str]) -> dict[str, Any]:
    """Return what the papers say of the cell; nothing in it comes from the truth."""
    scenario, arm, table = cell.scenario, cell.plant.arm, papers_of_cell(cell)
    tool = scenario.tool
    keys = ("alpha_deg", "a_mm", "theta_offset_deg", "d_mm")
    # A model's masses contain its tool.
    carried = [] if cell.model else [(arm.n_joints, tool.mass_kg, tool.centre_of_gravity_mm)]
    signs = table.signs or (1,) * arm.n_joints
    return {
        "format": _FORMAT,
        "kind": "tracker",
        "robot": table.name,
        "dhm_nominal": [
            {"joint": joint, **dict(zip(keys, row, strict=True)), **({} if sign > 0 else {"sign": sign})}
            for joint, (row, sign) in enumerate(zip(table.rows, signs, strict=True), start=1)
        ],
        # Where a model's robot stands was found from data; papers say nothing of it.
        "base_in_world_nominal": None
        if cell.model
        else dict.fromkeys(("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"), 0.0),
        "tool_nests_mm": _stated_nests(cell),
        "tool_nest_u_mm": tool.nest_u_mm,
        "tool_nest_axis": cell.facing.tolist(),
        "masses": [
            {"frame": frame, "kg": kg, "cog_mm": list(centre)}
            for frame, kg, centre in (*table.masses, *carried)
        ],
        "gravity_m_s2_world": list(cell.plant.gravity_m_s2),
        **_hints(arm, scenario.arm),
        "robot_repeatability_mm": scenario.arm.scatter_mm,
        "tracker_position_world_mm": list(scenario.tracker.position_mm),
        "fixed_nests_certified_mm": [list(nest) for nest in scenario.table.fixed_nests_mm],
        "fixed_nest_u_mm": scenario.table.nest_u_mm,
        "simulated": True,
        "files": files,
    }


def _stated_nests(cell: Cell) -> list[list[float] | None]:
    """Return nests as the papers have them; those that a model had to find are unknown."""
    found = {} if cell.model is None else cell.model.parameters.get("tool", {})
    return [
        None if f"nest_{number}_x" in found else list(nest)
        for number, nest in enumerate(cell.scenario.tool.nests_mm, start=1)
    ]


def _hints(arm: Arm, setup: ArmSetup) -> dict[str, list[float]]:
    """Return gear ratios and orders of compliance where they are stated: no hint is infinite or zero."""
    hints = {
        "gear_ratio": arm.gear_ratio if setup.states_gear_ratio else (),
        "typical_compliance_rad_per_Nmm": arm.typical_compliance_rad_per_n_mm,
    }
    return {key: list(values) for key, values in hints.items() if _are_hints(values)}


def _are_hints(values: tuple[float, ...]) -> bool:
    return bool(values) and all(0.0 < value < np.inf for value in values)


def truth_document(recording: Recording) -> dict[str, Any]:
    """Return the plant with everything planted, and where the nests truly were."""
    return {
        **plant_document(recording.cell),
        "true_positions_mm": {
            "calibration": recording.calibration.true_mm.tolist(),
            "validation": recording.validation.true_mm.tolist(),
        },
    }


def points_table(points: Points) -> Columns:
    """Columns of a `calibration` or `validation` file."""
    stops, n = points.stops, len(points.stops)
    columns = {
        "config": whole(np.arange(1, n + 1)),
        **joint_columns(stops.joints_deg, 5),
        **direction_columns(stops.direction),
        "time_s": decimals(stops.time_s, 1),
        "temperature_C": decimals(points.temperature_c, 2),
        "attachment": whole(stops.attachment),
        "nest": whole(points.nest),
        **coordinates(points.readings.position_mm),
        "u_mm": decimals(points.readings.u_mm, 4),
    }
    if stops.repeat_of.any():
        columns["repeat_of"] = [str(number) if number else "" for number in stops.repeat_of]
    return columns


def true_table(true_mm: FloatArray) -> Columns:
    """Columns of where all nests truly were at n stops, shape (n, nests, 3)."""
    n, nests, _ = true_mm.shape
    columns = {"config": whole(np.repeat(np.arange(1, n + 1), nests))}
    columns["nest"] = whole(np.tile(np.arange(1, nests + 1), n))
    places = true_mm.reshape(-1, 3)
    return {**columns, **{f"{axis}_mm": decimals(places[:, k], 6) for k, axis in enumerate("xyz")}}


def reference_table(references: References) -> Columns:
    """Columns of a `reference` file."""
    return {
        "time_s": decimals(references.time_s, 1),
        "fixed_nest": whole(references.fixed_nest),
        **coordinates(references.readings.position_mm),
        "u_mm": decimals(references.readings.u_mm, 4),
    }


def coordinates(position_mm: FloatArray) -> Columns:
    """Columns of positions, shape (n, 3)."""
    return {f"{axis}_mm": decimals(position_mm[:, i], 4) for i, axis in enumerate("xyz")}


def joint_columns(joints_deg: FloatArray, n: int) -> Columns:
    """Columns of joint angles, shape (m, J), with n decimals."""
    return {f"q{joint}_deg": decimals(angles, n) for joint, angles in enumerate(joints_deg.T, start=1)}


def direction_columns(direction: FloatArray) -> Columns:
    """Columns of the directions of approach, shape (m, J)."""
    return {f"dir{joint}": whole(signs) for joint, signs in enumerate(direction.T, start=1)}


def decimals(values: Any, n: int) -> list[str]:
    """Write numbers, shape (m,), with n decimals."""
    return [f"{value:.{n}f}" for value in values]


def whole(values: Any) -> list[str]:
    """Write numbers, shape (m,), without decimals."""
    return [str(int(value)) for value in values]


def write_tables(folder: Path, tables: Mapping[str, Columns]) -> dict[str, str]:
    """Write the tables that have rows into a folder, which may exist; returns their files by name."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {name: f"{name}.csv" for name, columns in tables.items() if any(columns.values())}
    for name, file in files.items():
        write_table(folder / file, tables[name])
    return files


def write_table(path: Path, columns: Mapping[str, Sequence[str]]) -> None:
    """Write a table with its header line."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))


def write_json(path: Path, document: Mapping[str, Any]) -> None:
    """Write a JSON file to be read by people as well."""
    path.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")
