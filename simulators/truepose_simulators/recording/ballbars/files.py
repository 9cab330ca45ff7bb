"""A recorded ballbar campaign as a folder, with the truth beside it."""

from pathlib import Path
from typing import Any

import numpy as np

from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.recording.ballbars.campaign import BallbarRecording
from truepose_simulators.recording.ballbars.readings import Cups, Legs, Sides
from truepose_simulators.recording.files import (
    Columns,
    campaign_document,
    coordinates,
    decimals,
    points_table,
    reference_table,
    true_table,
    truth_document,
    whole,
    write_json,
    write_table,
)


def write_ballbar_campaign(recording: BallbarRecording, folder: Path) -> None:
    """Write the folder, which may exist.

    `campaign.json` describes the legs; `calibration.csv`, the tracker campaign of the same robot, is a
    campaign of its own with `tracker.json` as its description.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tracker = recording.tracker
    tables = {
        "legs": _legs_table(recording.legs, recording.u_mm),
        "setup": _setup_table(recording.cups),
        "fixture": _fixture_table(recording.sides, recording.u_mm),
        "cups": _cups_table(recording.cups),
        "calibration": points_table(tracker.calibration),
        "validation": points_table(tracker.validation),
        "reference": reference_table(tracker.references),
    }
    present = {name: columns for name, columns in tables.items() if len(next(iter(columns.values())))}
    for name, columns in present.items():
        write_table(folder / f"{name}.csv", columns)
    write_table(folder / "true_validation.csv", true_table(recording.true_validation_mm))
    write_json(folder / "campaign.json", _ballbar_document(recording, [*present]))
    write_json(folder / "tracker.json", _tracker_document(recording, [*present]))
    write_json(folder / "truth.json", _truth(recording))


_OF_LEGS = frozenset({"legs", "setup", "fixture", "cups", "validation"})
_OF_POINTS = frozenset({"calibration", "validation", "reference"})


def _ballbar_document(recording: BallbarRecording, present: list[str]) -> dict[str, Any]:
    setup = recording.cell.scenario.ballbar
    files = {name: f"{name}.csv" for name in present if name in _OF_LEGS}
    return {
        **campaign_document(recording.cell, files),
        "kind": "ballbar",
        "ballbar_nominal_mm": setup.nominal_mm,
        "ballbar_range_mm": setup.range_mm,
        "setup_u_mm": setup.clamp_mm,
    }


def _tracker_document(recording: BallbarRecording, present: list[str]) -> dict[str, Any]:
    return campaign_document(recording.cell, {name: f"{name}.csv" for name in present if name in _OF_POINTS})


def _truth(recording: BallbarRecording) -> dict[str, Any]:
    cups, missed = recording.cups, recording.out_of_range
    return {
        **truth_document(recording.tracker),
        "cups": [
            {"placement": int(placement), "base_point": int(point), "position_mm": place.tolist()}
            for placement, point, place in zip(cups.placement, cups.base_point, cups.true_mm, strict=True)
        ],
        "true_legs_mm": recording.legs.true_mm.tolist(),
        "out_of_range": [
            {"config": int(config), "leg": [int(base), int(tool)], "length_mm": float(length)}
            for config, base, tool, length in zip(
                missed.config, missed.base_point, missed.tool_point, missed.length_mm, strict=True
            )
        ],
        "not_reached": list(recording.not_reached),
    }


def _legs_table(legs: Legs, u_mm: float) -> Columns:
    n_joints = legs.joints_deg.shape[1]
    return {
        "placement": whole(legs.placement),
        "config": whole(legs.config),
        **_joints(legs.joints_deg),
        **{f"dir{j + 1}": whole(legs.direction[:, j]) for j in range(n_joints)},
        "time_s": decimals(legs.time_s, 1),
        "temperature_C": decimals(legs.temperature_c, 2),
        "attachment": whole(legs.attachment),
        "init": whole(legs.init),
        "base_point": whole(legs.base_point),
        "tool_point": whole(legs.tool_point),
        "length_mm": decimals(legs.length_mm, 4),
        "u_mm": decimals(np.full(len(legs), u_mm), 5),
    }


def _setup_table(cups: Cups) -> Columns:
    return {
        "placement": whole(cups.placement),
        "base_point": whole(cups.base_point),
        **_joints(cups.joints_deg),
    }


def _fixture_table(sides: Sides, u_mm: float) -> Columns:
    return {
        "placement": whole(sides.placement),
        "kind": ["base" if placement else "tool" for placement in sides.placement],
        "point_a": whole(sides.point_a),
        "point_b": whole(sides.point_b),
        "length_mm": decimals(sides.length_mm, 4),
        "u_mm": decimals(np.full(len(sides.length_mm), u_mm), 5),
    }


def _cups_table(cups: Cups) -> Columns:
    return {
        "placement": whole(cups.placement),
        "base_point": whole(cups.base_point),
        **coordinates(cups.read_mm),
        "u_mm": decimals(cups.u_mm, 4),
    }


def _joints(joints_deg: FloatArray) -> Columns:
    return {f"q{j + 1}_deg": decimals(joints_deg[:, j], 5) for j in range(joints_deg.shape[1])}
