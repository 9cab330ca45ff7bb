"""A simulated cell measured without the service: drivers, runner and plans directly, journal in memory.

For figures over many cells, where storage and REST would only take time; they are in the demo and the
night run.
"""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np

from tests.helpers.domain import asking
from tests.helpers.domain.asking import question
from truepose.analysis.campaigns.tracker import point_readings
from truepose.app.simulation import running_simulation
from truepose.correction.proof import Proof, plan_proof, proof_of
from truepose.demo.errors import ServiceFailedError
from truepose.demo.truth import CellEndpoint, cell_endpoint
from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, PointReadings
from truepose.domain.cell import Cell, SimulatedCell
from truepose.domain.identification import Identification
from truepose.domain.ledger import LedgerEntry
from truepose.domain.robot import Nest, WorldRegistration
from truepose.domain.session import (
    PointTaken,
    Registration,
    SessionPlan,
    SessionState,
)
from truepose.exchange.cells.file import simulated_cell
from truepose.identification import identify
from truepose.planning.tracker.plans import plan_calibration, plan_validation
from truepose.planning.workspace.bodies import bodies_of
from truepose.planning.workspace.space import WorkSpace, space_of_cell
from truepose.sessions.engine.ways import look_in
from truepose.sessions.tracker.cell import SessionCell
from truepose.sessions.tracker.runner import TrackerRunner
from truepose.web.context import Endpoint
from truepose_drivers.api import Clock, PointTracker, RobotController
from truepose_drivers.registry import load_registry

_PERSON = "accuracy report"
_LOOK_S = 0.005  # between looks at whether the session asks for a person
_APPROACH_RAD = -0.0872664626  # -5 deg on all joints, thesis of A. Nubiola, 2014, section 2.4


@dataclass(frozen=True, slots=True)
class CellMeasurement:
    """What was measured, and the truth beside it."""

    campaign: Campaign
    ideal: Campaign  # the same configurations without noise and scatter, nests at their true places
    true_validation_mm: FloatArray  # (n, 3) noise-free positions at the validation readings


@dataclass(slots=True)
class _MemoryLedger:
    """Keeps what the runner stores; a crash loses it, which an accuracy report may."""

    points: list[PointTaken] = field(default_factory=list)
    registration: Registration | None = None
    lines: int = 0

    async def append(self, entry: LedgerEntry) -> int:
        """Keep the readings and the latest registration."""
        if entry.point is not None:
            self.points.append(entry.point)
        self.registration = entry.registration or self.registration
        self.lines += 1
        return self.lines

    async def writable(self) -> None:
        """Return at once: nothing is refused."""


async def measure_cell(scenario: str, seed: int, n_calibration: int, n_validation: int) -> CellMeasurement:
    """Measure a simulated cell over the wire, in cell time.

    Parameters
    ----------
    scenario : str
        Shipped name or file.
    seed : int
    n_calibration, n_validation : int
        Configurations; revisits come on top. No validation session where it is 0.

    Raises
    ------
    ServiceFailedError
        A session did not finish.
    """
    cell = simulated_cell(scenario, seed)
    async with _opened(cell, SimulatedCell(scenario, seed)) as (session_cell, truth):
        space = _work_space(cell)
        calibration, registration = await _session(session_cell, plan_calibration(space, n_calibration, seed))
        validation = None
        if n_validation:
            validation, _ = await _session(session_cell, plan_validation(space, n_validation, seed + 1))
        return await _with_truth(cell, calibration, validation, registration, truth)


async def prove_in_cell(
    scenario: str, seed: int, n_calibration: int, n_validation: int, n_targets: int
) -> tuple[Identification, Proof]:
    """Measure a simulated cell, identify it, and prove the model on targets that no one measured."""
    cell = simulated_cell(scenario, seed)
    async with _opened(cell, SimulatedCell(scenario, seed)) as (session_cell, truth):
        space = _work_space(cell)
        calibration, registration = await _session(session_cell, plan_calibration(space, n_calibration, seed))
        validation, _ = await _session(session_cell, plan_validation(space, n_validation, seed + 1))
        measured = await _with_truth(cell, calibration, validation, registration, truth)
        found = identify(measured.campaign)
        if found.model is None:
            raise ServiceFailedError(found.message)
        template = SessionPlan("validation", ())
        plan = plan_proof(space, template, found.model, n_targets, seed + 2)
        visited, _ = await _session(session_cell, plan)
        return found, proof_of(found.model, visited, found.model.repeatability_mm)


@asynccontextmanager
async def _opened(cell: Cell, simulated: SimulatedCell) -> AsyncIterator[tuple[SessionCell, CellEndpoint]]:
    async with running_simulation(simulated, pace=0) as simulation:
        found = {endpoint.device: endpoint for endpoint in simulation.endpoints}
        registry = load_registry()
        # the kind of each plugin is checked by the registry, so that a name stands for its protocol
        clock = cast(Clock, registry.open("cell_clock", _address(found["clock"]), None))
        tracker = cast(PointTracker, registry.open("leica_emscon", _address(found["tracker"]), clock))
        robot = cast(RobotController, registry.open("abb_open_abb", _address(found["robot"]), clock))
        async with cell_endpoint(found["truth"].host, found["truth"].port) as truth:
            yield _session_cell(cell, tracker, robot, clock), truth
        await tracker.close()
        await robot.close()


def _address(endpoint: Endpoint) -> dict[str, str | int]:
    return {"host": endpoint.host, "port": endpoint.port}


def _session_cell(cell: Cell, tracker: PointTracker, robot: RobotController, clock: Clock) -> SessionCell:
    return SessionCell(
        tracker=tracker,
        robot_controller=robot,
        clock=clock,
        robot=cell.robot,
        base=cell.base_nominal,
        nests=cell.nests,
        fixed_nests=cell.fixed_nests,
        look_at_ways=look_in(bodies_of(cell)),
        tracker_position_mm=cell.tracker_position_mm,
        joint_limits=cell.limits.joints or cell.robot.joint_limits,
    )


def _work_space(cell: Cell) -> WorkSpace:
    ranges = cell.limits.calibration or cell.robot.calibration_ranges
    if ranges is None:
        raise ServiceFailedError(f"The cell {cell.name} does not say in which ranges to measure.")
    return space_of_cell(cell, ranges, _APPROACH_RAD)


async def _session(cell: SessionCell, plan: SessionPlan) -> tuple[PointReadings, Registration]:
    """Run a session; each one places the tracker in the world anew."""
    ledger = _MemoryLedger()
    runner = TrackerRunner(plan, cell, ledger)
    running = asyncio.create_task(runner.run())
    while not running.done():
        await asyncio.sleep(_LOOK_S)
        if runner.state is SessionState.AWAITING_CONFIRMATION and question(runner):
            await asking.confirm(runner, _PERSON)
    if running.result() is not SessionState.FINISHED or ledger.registration is None:
        raise ServiceFailedError(f"A session of the accuracy report ended as {running.result().value}.")
    return point_readings(ledger.points), ledger.registration


async def _with_truth(
    cell: Cell,
    calibration: PointReadings,
    validation: PointReadings | None,
    registration: Registration,
    truth: CellEndpoint,
) -> CellMeasurement:
    x, y, z = (float(value) for value in registration.translation_mm)
    campaign = Campaign(
        robot=cell.robot,
        base_nominal=cell.base_nominal,
        nests=cell.nests,
        calibration=calibration,
        validation=validation,
        tracker_position_mm=(x, y, z),
        fixed_nests=cell.fixed_nests,
        registration=WorldRegistration(registration.covariance),
    )
    true_nests = await truth.tool_nests_mm()
    ideal = replace(
        campaign,
        calibration=replace(calibration, position_mm=await truth.positions_mm(calibration)),
        nests=tuple(_held(nest, place) for nest, place in zip(cell.nests, true_nests, strict=True)),
        validation=None,
    )
    judged = np.zeros((0, 3)) if validation is None else await truth.positions_mm(validation)
    return CellMeasurement(campaign, ideal, judged)


def _held(nest: Nest, place_mm: FloatArray) -> Nest:
    x, y, z = (float(value) for value in place_mm)
    return replace(nest, centre_mm=(x, y, z))
