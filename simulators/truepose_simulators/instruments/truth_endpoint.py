"""What only a simulator knows, as JSON: for the demo, tests, recordings and whoever scripts a failure.

- `{"op": "positions", "joints_rad": [[...], ...], "nests": [1, ...]}` gives
  `{"positions_mm": [[x, y, z], ...]}`;
- `{"op": "plant"}` gives link motions, springs, base, nests, the tracker's and the camera's frame, and
  what is planted;
- `{"op": "robot"}` gives `{"now_s": ..., "rest_s": ..., "joints_rad": [...]}`: when the arm came to rest, or
  will, and where it is now;
- `{"op": "aim"}` gives `{"fixed_nests_seen_from_tracker_mm": [[x, y, z], ...]}`, about as well as an
  operator aims by hand;
- `{"op": "effect", "name": ..., "subject": ..., "amplitude": ..., "from_s": ...}` plants a change, with
  the details of that effect as further keys (simulators/truepose_simulators/README.md);
- `{"op": "fault", "kind": ..., ...}` scripts a failure (the keys of a scenario's `[[fault]]`);
- `{"op": "attach"}` gives `{"attachment": 2}`: the tool was taken off and mounted anew.

Positions are nest centres in the world frame without noise and scatter, every joint approached from below,
at cell time `time_s` (a number or one per row; now when absent). `nests` has one number per row; without
it each row gives all nests. An impossible request is answered `{"error": "..."}`.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import TruthRequestError
from truepose_simulators.faults.file import read_fault
from truepose_simulators.instruments.camera import Camera
from truepose_simulators.instruments.cell_endpoints import Operations, carry_out, requests_endpoint
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.tracker import in_tracker_frame
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.scenarios.file import read_change


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


_LONGEST_LINE_BYTES = 1 << 26  # 10,000 configurations are 1.3 MB
_LATEST_S = 1e9  # thirty years of cell time
# An operator turns the tracker by hand to about this much.
_AIM_STEP_MM = 20.0


def truth_endpoint(cell: Cell) -> Endpoint:
    """Build the truth endpoint of a cell."""
    return requests_endpoint("truth", lambda line: answer(line, cell), longest_bytes=_LONGEST_LINE_BYTES)


def answer(line: bytes, cell: Cell) -> dict[str, Any]:
    """Carry out one request line."""
    return carry_out(line, _OPERATIONS, cell)


def _positions(request: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    joints = _joints(request.get("joints_rad"), cell.plant.arm.n_joints)
    n = len(joints)
    time_s = np.broadcast_to(_times(request.get("time_s", cell.clock.now_s), n), n)
    stops = cell.conditions(joints, np.ones_like(joints), time_s, np.full(n, float(cell.attachment)))
    positions = cell.true_positions(stops)
    if "nests" in request:
        nests = _nests(request["nests"], n, positions.shape[1])
        positions = positions[np.arange(n), nests - 1]
    return {"positions_mm": positions.tolist()}


def _plant(_: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    return plant_document(cell)


def _robot(_: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    motion, now_s = cell.robot.motion, cell.clock.now_s
    rest_s = motion.start_s + motion.duration_s
    return {"now_s": now_s, "rest_s": rest_s, "joints_rad": motion.joints_at(now_s).tolist()}


def _aim(_: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    seen = in_tracker_frame(cell.tracker.frame, cell.fixed_nests_mm())
    return {"fixed_nests_seen_from_tracker_mm": (np.round(seen / _AIM_STEP_MM) * _AIM_STEP_MM).tolist()}


def _effect(request: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    cell.plant_change(read_change(request, "effect"))
    return {}


def _fault(request: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    cell.add_fault(read_fault(request, "fault"))
    return {}


def _attach(_: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    cell.mount_tool_anew()
    return {"attachment": cell.attachment}


_OPERATIONS: Operations = {
    "positions": _positions,
    "plant": _plant,
    "robot": _robot,
    "aim": _aim,
    "effect": _effect,
    "fault": _fault,
    "attach": _attach,
}


def _joints(value: object, n_joints: int) -> FloatArray:
    joints = _numbers(value, "joints_rad") if isinstance(value, list) else np.zeros(0)
    if joints.ndim != 2 or joints.shape[1] != n_joints:
        raise TruthRequestError(f'key "joints_rad" must be a list of rows of {n_joints} angles [rad]')
    return joints


def _times(value: object, n: int) -> FloatArray:
    times = _numbers(value, "time_s")
    if times.ndim > 1 or times.size not in {1, n}:
        raise TruthRequestError(f'key "time_s" must be one time or {n}, one per row of joints_rad')
    if (np.abs(times) > _LATEST_S).any():
        raise TruthRequestError(f'key "time_s" must lie within {_LATEST_S:g} s of the start')
    return times


def _nests(value: object, n: int, n_nests: int) -> Any:
    nests = _numbers(value, "nests")
    whole = nests.shape == (n,) and np.isin(nests, np.arange(1, n_nests + 1)).all()
    if not whole:
        raise TruthRequestError(f'key "nests" must have {n} entries from 1 to {n_nests}, one per row')
    return nests.astype(int)


def _numbers(value: object, key: str) -> FloatArray:
    try:
        numbers = np.array(value, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise TruthRequestError(f'key "{key}" must hold numbers, rows of equal length') from error
    if not np.isfinite(numbers).all():
        raise TruthRequestError(f'key "{key}" must hold finite numbers')
    return numbers
