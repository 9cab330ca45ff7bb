"""A change planted by the service's cell file reaches the simulated cell with all that it says."""

import math

import pytest

from truepose.app.errors import ScenarioRefusedError
from truepose.app.simulation import running_simulation
from truepose.demo.truth import cell_endpoint
from truepose.domain.cell import PlantedEffect, SimulatedCell


async def test_name_subject_amplitude_time_and_details_arrive():
    details = {"source": "joint 4"}
    drift = {"rotation_rad_per_h": 5e-5, "direction": (0.0, 0.0, 1.0)}
    effects = (
        PlantedEffect("joint_coupling", "joint 6", 5e-4, 600.0, details),
        PlantedEffect("base_drift", "base", 0.06, 0.0, drift),
    )

    async with running_simulation(SimulatedCell("irb120-clean", 3, effects), pace=0) as simulation:
        at = next(endpoint for endpoint in simulation.endpoints if endpoint.device == "truth")
        joints = [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]] * 2
        async with cell_endpoint(at.host, at.port) as truth:
            planted = (await truth.ask("plant"))["effects"]
            moved = await truth.ask("positions", joints_rad=joints, time_s=[599.0, 600.0], nests=[3, 3])
        before, after = moved["positions_mm"]

    assert planted == [
        {"name": "joint_coupling", "subject": "joint 6", "amplitude": 5e-4, "from_s": 600.0, **details},
        {"name": "base_drift", "subject": "base", "amplitude": 0.06, "from_s": 0.0}
        | {"rotation_rad_per_h": 5e-5, "direction": [0.0, 0.0, 1.0]},
    ]
    # Joint 6 turns by 5e-4 rad, nest 3 is 150 off its axis: 0.075; a second of drift is nothing beside it.
    assert math.dist(after, before) == pytest.approx(0.075, rel=0.01)


async def test_a_detail_that_the_effect_does_not_know_ends_the_cell():
    wrong = PlantedEffect("joint_gain", "joint 3", 1e-3, 0.0, {"form_s": 600.0})

    with pytest.raises(ScenarioRefusedError):
        async with running_simulation(SimulatedCell("irb120-clean", 3, (wrong,)), pace=0):
            pass


async def test_of_a_cell_that_ended_by_itself_no_pipe_stays_open(forked_processes):
    async with running_simulation(SimulatedCell("irb120-clean", 3), pace=0) as simulation:
        process = simulation._process
        process.kill()
        process._process.join()  # and the loop has not heard of it

    assert process.stdin.is_closing()
