"""The truth about a cell as a JSON document, for the truth endpoint and beside recorded campaigns."""

from typing import Any

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.camera.device import Camera
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.physics.rigid import FloatArray


def plant_document(cell: Cell) -> dict[str, Any]:
    """Return link motions, springs, base, nests and tracker as they are now, and everything planted."""
    return {
        "robot": cell.plant.arm.name,
        "scenario": cell.scenario.name,
        "seed": cell.seed,
        "base": cell.plant.motions[0].tolist(),
        "links": cell.plant.motions[1:-1].tolist(),
        "compliance_rad_per_n_mm": cell.plant.compliance_rad_per_n_mm.tolist(),
        "tool_nests_mm": cell.true_nests_mm(cell.conditions_now())[0].tolist(),
        "fixed_nests_mm": cell.fixed_nests_mm().tolist(),
        "tracker_frame": _frame(cell.tracker.frame),
        "camera": None if cell.scenario.camera is None else _camera(Camera(cell, cell.scenario.camera)),
        "cups": [
            {"placement": cup.placement, "base_point": cup.base_point, "position_mm": cup.place_mm.tolist()}
            for cup in cell.fixture.cups
        ],
        "ballbar": {
            "accidents": cell.hands.accidents,
            "motions_attached": cell.hands.motions_attached,
        },
        "effects": [_stated(change) for change in cell.planted.changes],
        "identified": None if cell.model is None else dict(cell.model.parameters),
    }


def _camera(camera: Camera) -> dict[str, Any]:
    return {**_frame(camera.frame), "artefact_mm": camera.defined_mm.tolist()}


def _frame(frame: FloatArray) -> dict[str, Any]:
    return {"rotation": frame[:3, :3].tolist(), "translation_mm": frame[:3, 3].tolist()}


def _stated(change: PlantedChange) -> dict[str, Any]:
    """Return a planted change as a scenario or a request would plant it."""
    stated = {name: getattr(change, name) for name in ("name", "subject", "amplitude", "from_s")}
    return {**stated, **change.details}
