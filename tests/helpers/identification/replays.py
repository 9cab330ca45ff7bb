"""An identified model in the place of the simulated robot, which takes another route through the physics."""

import csv
import json

import numpy as np

from truepose.exchange.models.file import write_model
from truepose_simulators.recording.__main__ import main


def write_stops(folder, stops, nest):
    """A campaign folder whose readings are nothing but places to write into."""
    folder.mkdir()
    (folder / "campaign.json").write_text(json.dumps({"format": 1, "files": {"calibration": "rows.csv"}}))
    joints = range(stops.joints_rad.shape[1])
    with (folder / "rows.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        columns = [f"q{j + 1}_deg" for j in joints] + [f"dir{j + 1}" for j in joints]
        circumstances = ["time_s", "temperature_C", "attachment", "nest", "x_mm", "y_mm", "z_mm", "u_mm"]
        writer.writerow(["config", *columns, *circumstances])
        for k in range(len(stops)):
            angles = [f"{angle:.5f}" for angle in np.degrees(stops.joints_rad[k])]
            here = [stops.time_s[k], stops.temperature_c[k], stops.attachment[k], nest[k], 0, 0, 0, 0.01]
            writer.writerow([stops.config[k], *angles, *stops.direction[k], *here])
    return folder


def replayed_mm(folder):
    with (folder / "rows.csv").open(encoding="utf-8") as file:
        return np.array([[float(row[f"{axis}_mm"]) for axis in "xyz"] for row in csv.DictReader(file)])


def went_mm(model, stops, nest, scenario, folder):
    """Where a robot that is the model truly has its nests at stops, (n, 3)."""
    measured = write_stops(folder / "measured", stops, nest)
    write_model(model, folder / "model.json")
    asked = ["--model", str(folder / "model.json"), "--replay", str(measured)]
    assert main([scenario, *asked, "--out", str(folder / "out")]) == 0
    return replayed_mm(folder / "out")
