"""A session whose camera reads poses: where they are put, what is refused, how it goes on."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.unit.service.sessions.stand_ins import Device
from tests.unit.service.sessions.tracker.fakes import IRB120, NESTS, FakeCell, make_plan, make_stop
from tests.unit.service.sessions.tracker.operators import PatientOperator, run_session
from truepose.domain.cell import Camera
from truepose.domain.ledger import EntryKind
from truepose.domain.robot import FramePlacement, JointRange, Nest
from truepose.domain.session import SessionState
from truepose.kinematics.frames import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
)
from truepose.sessions.engine.nominal_arm import nominal_chain
from truepose.sessions.errors import PlanRefusedError
from truepose.sessions.tracker.camera_measurement import stated_place
from truepose.sessions.tracker.dry_run import check_plan, dry_run
from truepose.sessions.tracker.runner import TrackerRunner
from truepose_drivers.api import PoseReading
from truepose_drivers.errors import ArtefactNotSeenError, ConnectionLostError

CENTRE = (75.0, 31.225, 155.0)
CAMERA = Camera((2200.0, 0.0, 900.0), (0.0, 0.0, 0.0), 4, 0.032, 4.7e-4, 4.2e-4)
SHOWN = (*NESTS, Nest(CENTRE, 0.028))


class FakeCamera(Device):
    """Sees the artefact on the arm, from where it stands by its cell file."""

    settings = ""

    def __init__(self, cell):
        super().__init__("Northern Digital", "Polaris Vega VT", "P-1", "2.1")
        self._cell = cell
        self.initialised = 0
        self.measurements = 0
        self.faults = {}  # number of the measurement, from 0
        self.off_mm = np.zeros(3)  # of the artefact, world
        self.off_rad = np.zeros(3)
        self.changes = {}  # of every reading

    async def initialise(self):
        self.initialised += 1

    async def measure_pose(self, *, duration_s):
        number, self.measurements = self.measurements, self.measurements + 1
        self._cell.clock.time_s += duration_s
        if number in self.faults:
            self.connected = not isinstance(self.faults[number], ConnectionLostError)
            raise self.faults[number]
        stands = stated_place(CAMERA)
        arm = nominal_chain(IRB120, FramePlacement(), np.array([self._cell.robot.joints]))
        turn = stands.rotation.T @ rotation_from_vector(self.off_rad) @ arm.end_rotation[0]
        place = (arm.points(np.zeros(3))[0] + self.off_mm - stands.translation_mm) @ stands.rotation
        reading = PoseReading(
            quaternion=tuple(quaternion_from_rotation(turn).tolist()),
            position_mm=tuple(place.tolist()),
            position_deviation_mm=(0.01, 0.01, 0.01),
            rotation_deviation_rad=1e-4,
            rms_mm=0.1,
            frames=60,
            duration_s=duration_s,
            time_s=self._cell.clock.time_s,
        )
        return replace(reading, **self.changes)


def camera_cell():
    """A cell whose camera stands in the tracker's place."""
    fake = FakeCell()
    fake.camera = FakeCamera(fake)
    fake.cell = replace(fake.cell, tracker=fake.camera, nests=SHOWN, fixed_nests=(), camera=CAMERA)
    return fake


@pytest.fixture
def fake():
    return camera_cell()


def plan_of(n=3):
    stops = tuple(replace(make_stop(config), nest=4) for config in range(1, n + 1))
    return make_plan(stops=stops, measures="poses")


async def test_each_stop_gives_the_pose_of_the_artefact_in_the_world_of_the_camera(fake):
    ended = await run_session(fake, plan_of())

    assert ended is SessionState.FINISHED
    for point in fake.journal.points:
        arm = nominal_chain(IRB120, FramePlacement(), np.array([point.commanded_rad]))
        assert point.position_world_mm == pytest.approx(arm.points(np.array(CENTRE))[0], abs=1e-9)
        turn = rotation_from_quaternion(np.array(point.quaternion))
        assert turn == pytest.approx(arm.end_rotation[0], abs=1e-12)
        assert (point.nest, point.standard_uncertainty_mm) == (4, CAMERA.position_u_mm)
        assert (point.rotation_uncertainty_rad, point.instrument_serial) == (CAMERA.rotation_u_rad, "P-1")
    assert fake.journal.fixed == []


async def test_the_camera_is_put_where_the_cell_file_says_and_nothing_is_measured_for_it(fake):
    await run_session(fake, plan_of(1))

    (placed,) = fake.journal.registrations
    assert placed.translation_mm == pytest.approx(CAMERA.position_mm)
    assert placed.rotation @ [0.0, 0.0, -1.0] == pytest.approx(
        -np.array(CAMERA.position_mm) / math.hypot(2200, 900)
    )
    assert placed.rotation[2, 0] == pytest.approx(0.0)  # x is level
    assert (placed.instrument_serial, math.isnan(placed.rms_mm)) == ("P-1", True)


async def test_an_instrument_that_states_no_fit_of_markers_is_believed(fake):
    fake.camera.changes = {"rms_mm": math.nan}

    await run_session(fake, plan_of(1))

    (point,) = fake.journal.points
    assert math.isnan(point.rms_mm)


def test_an_upright_instrument_has_its_z_axis_up_and_looks_along_x():
    stands = stated_place(replace(CAMERA, upright=True, looks_at_mm=(2200.0, -500.0, 0.0)))

    assert stands.rotation == pytest.approx(np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    assert stands.translation_mm == pytest.approx(CAMERA.position_mm)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"off_mm": np.array([80.0, 0.0, 0.0])}, "80 mm"),
        ({"off_rad": np.array([0.0, 0.0, 0.2])}, "11.5 deg"),
        ({"changes": {"rms_mm": 0.8}}, "match only to within 0.800 mm"),
        ({"changes": {"position_deviation_mm": (0.3, 0.0, 0.0)}}, "scatter by 0.300 mm"),
        ({"changes": {"position_mm": (math.nan, 0.0, 0.0)}}, "not a pose"),
        ({"changes": {"quaternion": (0.0, 0.0, 0.0, 0.0)}}, "not a pose"),
    ],
)
async def test_what_is_no_pose_of_this_artefact_at_rest_is_not_kept(change, said, fake):
    for name, value in change.items():
        setattr(fake.camera, name, value)
    operator = PatientOperator(patience=1)

    await run_session(fake, plan_of(1), operator)

    assert fake.journal.points == []
    assert any(said in question for question in operator.questions)


async def test_an_arm_that_errs_by_millimetres_is_what_the_session_is_for(fake):
    fake.camera.off_mm = np.array([9.0, -9.0, 9.0])

    await run_session(fake, plan_of(1))

    assert len(fake.journal.points) == 1


async def test_a_single_frame_has_no_scatter_to_be_judged_by(fake):
    fake.camera.changes = {"position_deviation_mm": (math.nan,) * 3, "frames": 1}

    await run_session(fake, plan_of(1))

    assert len(fake.journal.points) == 1


async def test_a_stop_whose_artefact_is_hidden_is_skipped_and_the_others_are_measured(fake):
    fake.camera.faults[1] = ArtefactNotSeenError("the camera did not see the artefact")

    ended = await run_session(fake, plan_of(4))

    assert ended is SessionState.FINISHED
    assert [point.config for point in fake.journal.points] == [1, 3, 4]
    assert [skipped.config for skipped in fake.journal.skipped] == [2]


async def test_after_a_lost_link_the_camera_is_made_ready_anew_and_the_stop_begins_again(fake):
    fake.camera.faults[1] = ConnectionLostError("the cable was pulled")

    ended = await run_session(fake, plan_of(3))

    assert ended is SessionState.FINISHED
    assert [point.config for point in fake.journal.points] == [1, 2, 3]
    assert fake.camera.initialised == 2


async def test_a_session_that_a_service_left_goes_on_where_it_ended(fake):
    await run_session(fake, plan_of(3))
    kinds = [entry.kind for entry in fake.journal.entries]
    left = tuple(fake.journal.entries[: kinds.index(EntryKind.MEASURED) + 1])
    before = len(fake.journal.points)

    ended = await run_session(fake, plan_of(3), entries=left)

    assert ended is SessionState.FINISHED
    assert [point.config for point in fake.journal.points[before:]] == [2, 3]


async def test_another_camera_measures_nothing_before_a_person_has_accepted_it(fake):
    plan, seen = plan_of(3), []

    async def exchange():
        if len(fake.journal.points) == 1:
            fake.camera.serial = "P-2"

    fake.robot.before_move = exchange
    operator = PatientOperator(patience=2)
    operator.before_answer = seen.append

    await run_session(fake, plan, operator)

    assert len(fake.journal.points) == 1
    assert any("P-2" in question for question in seen)


def test_the_dry_run_counts_one_reading_a_stop_and_no_fixed_nests():
    run = dry_run(plan_of(5), IRB120, FramePlacement(), SHOWN, 0)

    assert (run.configurations, run.readings) == (5, 5)


def test_no_fixed_nests_are_asked_for():
    plan, limits = plan_of(2), (JointRange(-math.pi, math.pi),) * 6

    check_plan(plan, IRB120, SHOWN, (), limits)

    with pytest.raises(PlanRefusedError, match="reference nests"):
        check_plan(replace(plan, measures="points"), IRB120, SHOWN, (), limits)


def test_a_pose_is_told_at_the_centre_of_the_artefact_and_nowhere_else():
    limits = (JointRange(-math.pi, math.pi),) * 6
    elsewhere = replace(plan_of(2), stops=(make_stop(1), *plan_of(2).stops[1:]))

    with pytest.raises(PlanRefusedError, match=r"Configuration 1 asks for tool nest 1; .* nest 4"):
        check_plan(elsewhere, IRB120, SHOWN, (), limits)


def test_a_plan_of_poses_needs_a_camera(cell):
    with pytest.raises(PlanRefusedError, match="no camera"):
        TrackerRunner(plan_of(1), replace(cell.cell, nests=SHOWN), cell.journal)
