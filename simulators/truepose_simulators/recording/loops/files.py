"""A recorded closed loop as a campaign folder, with the truth beside it."""

from pathlib import Path
from typing import Any

import numpy as np

from truepose_simulators.cell.truth_document import plant_document
from truepose_simulators.recording.files import (
    Columns,
    campaign_document,
    decimals,
    points_table,
    true_table,
    whole,
    write_json,
    write_table,
)
from truepose_simulators.recording.loops.campaign import Contacts, LoopRecording


def write_loop(recording: LoopRecording, folder: Path) -> None:
    """Write the folder, which may exist."""
    folder.mkdir(parents=True, exist_ok=True)
    tables = {
        "contacts": _contacts_table(recording.calibration, recording.loop.u_mm),
        "validation_contacts": _contacts_table(recording.validation, recording.loop.u_mm),
        "targets": _targets_table(recording),
        "target_distances": _distances_table(recording),
        "validation": points_table(recording.points),
    }
    present = {name: columns for name, columns in tables.items() if len(next(iter(columns.values()), []))}
    for name, columns in present.items():
        write_table(folder / f"{name}.csv", columns)
    write_table(folder / "true_validation.csv", true_table(recording.true_points_mm))
    write_json(folder / "campaign.json", _document(recording, [*present]))
    write_json(folder / "truth.json", plant_document(recording.cell))


def _document(recording: LoopRecording, present: list[str]) -> dict[str, Any]:
    document = campaign_document(recording.cell, {name: f"{name}.csv" for name in present})
    document["kind"] = "contacts"
    if not recording.loop.nests_known:
        stated = enumerate(document["tool_nests_mm"], start=1)
        document["tool_nests_mm"] = [
            None if number in recording.loop.nests else centre for number, centre in stated
        ]
    return document


def _contacts_table(contacts: Contacts, u_mm: float) -> Columns:
    n_joints = contacts.joints_deg.shape[1]
    columns = {
        "config": whole(contacts.config),
        # A probe stops the arm anywhere: its joints are read with all that encoders have.
        **{f"q{j + 1}_deg": decimals(contacts.joints_deg[:, j], 6) for j in range(n_joints)},
        **{f"dir{j + 1}": whole(contacts.direction[:, j]) for j in range(n_joints)},
        "time_s": decimals(contacts.time_s, 1),
        "temperature_C": decimals(contacts.temperature_c, 2),
        "target": whole(contacts.target),
        "nest": whole(contacts.nest),
        "reading_mm": decimals(contacts.reading_mm, 4),
        "u_mm": decimals(np.full(len(contacts), u_mm), 5),
    }
    if (contacts.axis >= 0).any():
        columns["axis"] = ["xyz"[axis] for axis in contacts.axis]
    return columns


def _targets_table(recording: LoopRecording) -> Columns:
    loop = recording.loop
    return {
        "target": whole(np.arange(1, len(loop.placed) + 1)),
        "kind": [placed.kind for placed in loop.placed],
        "zero_mm": ["" if placed.zero_mm is None else f"{placed.zero_mm:.4f}" for placed in loop.placed],
        "u_zero_mm": ["" if placed.zero_mm is None else f"{loop.u_zero_mm:.5f}" for placed in loop.placed],
        "form_mm": decimals(np.full(len(loop.placed), loop.form_mm), 5),
    }


def _distances_table(recording: LoopRecording) -> Columns:
    if recording.distance_mm is None or recording.loop.u_distance_mm is None:
        return {}
    return {
        "target_a": ["1"],
        "target_b": ["2"],
        "distance_mm": [f"{recording.distance_mm:.5f}"],
        "u_mm": [f"{recording.loop.u_distance_mm:.5f}"],
    }
