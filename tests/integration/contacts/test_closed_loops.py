"""Closed loops on simulated cells, through the drivers: planned, run, made a campaign of, identified."""

from dataclasses import replace

import pytest

from tests.contract.benches import in_memory
from tests.helpers.instruments.memory_link import MemoryLink
from tests.unit.service.sessions.stand_ins import nothing_in_the_way
from tests.unit.service.sessions.tracker.fakes import ListLedger
from tests.unit.service.sessions.tracker.operators import PatientOperator
from truepose.analysis.campaigns.contacts import contact_campaign, judged_by_contacts, readings_of
from truepose.analysis.errors import NothingMeasuredError, SessionsDifferError
from truepose.domain.cell import DeviceEntry
from truepose.domain.contacts import ContactPlan, ContactTaken, Target, TargetKind
from truepose.domain.session import SessionState
from truepose.exchange.campaigns.zip_file import read_campaign_zip, write_campaign_zip
from truepose.exchange.cells.file import cell_given
from truepose.planning.contacts.plan import plan_of
from truepose.planning.contacts.plan_request import ContactPlanRequest
from truepose.sessions.contact.measuring import ContactCell, GaugeBox
from truepose.sessions.contact.runner import ContactRunner
from truepose.storage.records import SessionSetup
from truepose_drivers.abb_open_abb.driver import OpenAbbRobot
from truepose_drivers.cell_clock.driver import CellClock
from truepose_drivers.keyence_gt2.driver import KeyenceUnit
from truepose_drivers.line_gauges.conversation import GaugeSettings, LineGauges
from truepose_simulators.cell.environment import CellClock as SimulatedClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.cell_endpoints import clock_endpoint
from truepose_simulators.instruments.gauges.length_source import Electronics
from truepose_simulators.instruments.gauges.text_boxes import keyence_gt2_endpoint
from truepose_simulators.instruments.robot.open_abb import MotionProgram, robot_endpoint
from truepose_simulators.scenarios.file import load_scenario

LR_MATE = cell_given("lrmate-tilted")
SPHERES = tuple(
    Target(number, TargetKind.SPHERE, 16.0, 0.002, place_mm=(420.0, y_mm, 80.0))
    for number, y_mm in ((1, -120.0), (2, 120.0))
)
DRUMS = ((700.0, -500.0, 0.0), (700.0, 500.0, 0.0), (-300.0, 600.0, 0.0))
CORNER = ((0.8165, 0.0, -0.5774), (-0.4082, 0.7071, -0.5774), (-0.4082, -0.7071, -0.5774))
LOOPS = {
    "lrmate-sphere": ContactPlanRequest(
        "probe", (replace(SPHERES[0], place_mm=(420.0, -100.0, 80.0)),), 6
    ),
    "lrmate-two-spheres": ContactPlanRequest("probe", SPHERES, 6),
    "lrmate-plane": ContactPlanRequest(
        "probe", (Target(1, TargetKind.PLANE, place_mm=(430.0, 0.0, 60.0)),), 6
    ),
    "lrmate-three-gauges": ContactPlanRequest(
        "gauges",
        tuple(
            Target(number, TargetKind.GAUGE, place_mm=(430.0, 0.0, 120.0), normal=normal)
            for number, normal in enumerate(CORNER, start=1)
        ),
        6,
        stroke_mm=7.5,
    ),
    "lrmate-wires": ContactPlanRequest(
        "wires",
        tuple(Target(n, TargetKind.WIRE, 700.0, place_mm=place) for n, place in enumerate(DRUMS, start=1)),
        6,
        stroke_mm=480.0,
        margin_mm=20.0,
        reading_u_mm=0.02,
    ),
    "lrmate-ball-sensor": ContactPlanRequest(
        "sensor", (Target(1, TargetKind.BALL, place_mm=(430.0, 0.0, 120.0)),), 6, reading_u_mm=0.002
    ),
}  # fmt: skip


def wish(scenario, **changes):
    return replace(LOOPS[scenario], nest=2, **changes)


async def run(scenario, plan, seed=2):
    """Run a plan on a simulated cell; returns the state it ended in and what the ledger holds."""
    cell = Cell(load_scenario(scenario), seed, SimulatedClock(0))

    def link(endpoint):
        return MemoryLink(in_memory(endpoint, []))

    clock = CellClock(lambda: link(clock_endpoint(cell.clock)))
    boxes = tuple(
        GaugeBox(
            f"gauge-{number}",
            LineGauges(
                link(keyence_gt2_endpoint([Electronics(gauge, cell.faults, cell.clock)])),
                clock,
                KeyenceUnit(),
                GaugeSettings(),
                settle_s=0.0,
            ),
        )
        for number, gauge in enumerate(cell.loop, start=1)
    )
    robot = OpenAbbRobot(link(robot_endpoint(cell, MotionProgram(cell))), clock)
    ledger = ListLedger()
    known = ContactCell(
        gauges=boxes,
        robot_controller=robot,
        clock=clock,
        robot=LR_MATE.robot,
        look_at_ways=nothing_in_the_way,
    )
    runner = ContactRunner(plan, known, ledger)
    state = await PatientOperator(30, look_s=0.01).attend_from_the_start(runner)
    for device in (robot, clock, *(box.gauge for box in boxes)):
        await device.close()
    return state, ledger


@pytest.mark.parametrize("scenario", LOOPS)
async def test_a_loop_is_planned_run_and_written_as_a_campaign(scenario):
    plan = plan_of(LR_MATE, wish(scenario))

    state, ledger = await run(scenario, plan)
    cell = replace(
        LR_MATE,
        robot_serial_number="F-1",
        devices=(
            DeviceEntry("robot", "fanuc-rmi", {}, "F-2"),
            DeviceEntry("probe", "mitutoyo-usb-itn", {}, "M-3"),
        ),
    )
    campaign = contact_campaign("session 1", SessionSetup(cell), plan, readings_of(ledger.entries), {"probe"})
    back = read_campaign_zip(write_campaign_zip(campaign))

    assert state is SessionState.FINISHED
    assert [skipped.reason for skipped in ledger.skipped] == []
    assert len(campaign.contacts) == 6 * plan.channels
    assert back.targets == campaign.targets
    assert (back.robot_serial_number, back.instrument_serial_number) == ("F-1", "M-3")
    assert back.contacts.reading_mm == pytest.approx(campaign.contacts.reading_mm, abs=1e-6)


def plain_reading(target):
    return ContactTaken(1, 2, (0.1,) * 6, (0.1,) * 6, (1,) * 6, 5.0, 1, (target,), (), (0.001,), 0.001)


def test_sessions_at_other_targets_do_not_judge_each_other():
    plan = ContactPlan("probe", "calibration", 2, SPHERES, ())
    campaign = contact_campaign("session 1", SessionSetup(LR_MATE), plan, [plain_reading(1)])

    other = replace(plan, targets=SPHERES[:1])

    with pytest.raises(SessionsDifferError, match="session 2"):
        judged_by_contacts(campaign, (plan, other), "session 2", [plain_reading(1)])
    with pytest.raises(NothingMeasuredError):
        judged_by_contacts(campaign, (plan, plan), "session 2", ())


def test_nothing_read_is_no_campaign():
    plan = ContactPlan("probe", "calibration", 2, SPHERES, ())

    with pytest.raises(NothingMeasuredError, match="session 1"):
        contact_campaign("session 1", SessionSetup(LR_MATE), plan, ())


def test_a_zero_that_is_rough_is_left_to_be_found():
    plan = ContactPlan("probe", "calibration", 2, SPHERES, (), found_zeros=(2,))

    campaign = contact_campaign("session 1", SessionSetup(LR_MATE), plan, [plain_reading(1)])

    assert [target.zero_mm for target in campaign.targets] == [16.0, None]
