"""A laser tracker tells poses of a probe on the flange: a session over TCP, through the real drivers."""

import asyncio
from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.helpers.machine import HANGS_S
from tests.system.session_bench import LOOK_S, Bench, bench
from tests.unit.service.sessions.tracker.operators import PatientOperator
from truepose.domain.cell import Camera
from truepose.domain.robot import Nest
from truepose.domain.session import SessionState
from truepose.kinematics.frames import (
    rigid_alignment,
    rotation_from_quaternion,
    rotation_from_vector,
    vector_from_rotation,
)
from truepose.kinematics.poses import centre
from truepose.planning.tracker.plans import plan_calibration
from truepose.sessions.tracker.runner import TrackerRunner
from truepose_drivers.leica_emscon.probe import PLUGIN
from truepose_simulators import scenarios

PROBE_CELL = Path(scenarios.__file__).parent / "irb120-probe.toml"
_ABOUT_RAD = 0.01  # as somebody reads the direction of the horizontal zero off the display


def shown_to(opened: Bench, turned) -> None:
    """Put the probe before the tracker, which stands upright about where it is said to."""
    about = rotation_from_vector(np.array([0.0, 0.0, _ABOUT_RAD]))
    position = np.array(opened.cell.tracker_position_mm)
    looks_at = position + 1000.0 * about @ turned[:, 0]
    centre_mm = centre(np.array([nest.centre_mm for nest in opened.cell.nests]))
    camera = Camera(
        position_mm=tuple(position.tolist()),
        looks_at_mm=tuple(looks_at.tolist()),
        nest=4,
        position_u_mm=0.02,
        rotation_u_rad=6e-5,
        artefact_rotation_u_rad=6e-5,
        upright=True,
    )
    nests = (*opened.cell.nests, Nest(tuple(centre_mm.tolist()), 0.002))
    opened.cell = replace(opened.cell, tracker=opened.tracker, nests=nests, fixed_nests=(), camera=camera)


async def test_every_pose_is_kept_to_the_trackers_noise():
    async with bench("irb120-tilted", seed=11, scenario_file=PROBE_CELL) as opened:
        opened.tracker = PLUGIN.open(opened.tracker_address, opened.clock)
        stands = (await opened.ask(op="plant"))["tracker_frame"]
        turned, moved_mm = np.array(stands["rotation"]), np.array(stands["translation_mm"])
        shown_to(opened, turned)
        plan = plan_calibration(opened.space, 8, seed=1, n_candidates=100)
        stops = tuple(replace(stop, nest=4) for stop in plan.stops)
        runner = TrackerRunner(replace(plan, stops=stops, measures="poses"), opened.cell, opened.journal)

        async with asyncio.timeout(HANGS_S):
            ended = await PatientOperator(look_s=LOOK_S).attend(runner, asyncio.create_task(runner.run()))

        points = opened.journal.points
        joints = [point.commanded_rad for point in points]
        true_mm = np.array((await opened.ask(op="positions", joints_rad=joints))["positions_mm"])

    assert ended is SessionState.FINISHED
    assert opened.journal.skipped == []
    read_mm = np.array([point.position_tracker_mm for point in points]) @ turned.T + moved_mm
    # tracker 0.0155 mm per axis at 2.6 m, arm 0.0035, nests 0.002, the lever of 6e-5 rad over 160 mm 0.010:
    # 0.019 mm per axis; of some 10 x 3 values half as much again is chance
    assert np.sqrt(np.mean((read_mm - true_mm.mean(axis=1)) ** 2)) < 0.03
    nests_mm = np.array([nest.centre_mm for nest in opened.cell.nests[:3]])
    into_true = turned @ opened.journal.registrations[-1].rotation.T
    off_rad = [
        vector_from_rotation(
            into_true
            @ rotation_from_quaternion(np.array(point.quaternion))
            @ rigid_alignment(nests_mm, where_mm)[0].T
        )
        for point, where_mm in zip(points, true_mm, strict=True)
    ]
    # 6e-5 rad about each axis; the nests' own 0.002 mm over 100 mm and the scatter of the arm add 4e-5
    assert np.sqrt(np.mean(np.square(off_rad))) < 1.2e-4
    assert any("measures the probe T-Mac" in note for note in opened.journal.notes)
    assert {point.instrument_serial for point in points} == {"390011"}
