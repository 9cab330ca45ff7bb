"""Faults from a file, in sessions on simulated cells: what each makes of a session, and what it leaves alone.

Many faults in few sessions, in the cell's own time; `docs/faults.md` says what is due for each.
"""

import asyncio
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.helpers.machine import HANGS_S
from tests.system.session_bench import LOOK_S, bench
from tests.unit.service.sessions.tracker.operators import PatientOperator
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.planning.tracker.plans import plan_validation
from truepose.sessions.engine.prompts import CELL_CLEAR
from truepose.sessions.tracker.runner import TrackerRunner

DROPPING = 'extends = "{}"\n[arm]\nrefusal = "drop"\n'


@dataclass
class Came:
    """What came of a session."""

    questions: list[str]  # after the first, which every session begins with
    points: list
    skipped: dict[int, str]
    worst_mm: float  # reading against the truth of the cell as it ended

    @property
    def configurations(self):
        return [point.config for point in self.points]

    def asked(self, *sentences):
        """Whether these were among the questions, in this order."""
        questions = iter(self.questions)
        return all(any(sentence in question for question in questions) for sentence in sentences)


async def measured(folder, base, faults, n, **changes):
    """Measure a plan of `n` configurations in a cell with faults."""
    scenario, file = folder / "faulty.toml", folder / "faults.toml"
    scenario.write_text(DROPPING.format(base))
    file.write_text(faults)
    async with bench(base, 31, "--faults", str(file), scenario_file=scenario) as opened:
        plan = replace(plan_validation(opened.space, n, seed=9), registration_readings=3, **changes)
        operator = PatientOperator(patience=20, look_s=LOOK_S)
        runner = TrackerRunner(plan, opened.cell, opened.journal)
        running = asyncio.create_task(runner.run())
        async with asyncio.timeout(HANGS_S):
            ended = await operator.attend(runner, running)
        errors_mm = await opened.true_errors_mm()
    assert ended is SessionState.FINISHED, operator.questions
    skipped = {item.config: item.reason for item in opened.journal.skipped}
    return Came(operator.questions[1:], opened.journal.points, skipped, float(errors_mm.max()))


async def test_stops_and_lost_links_wait_for_a_person_and_cost_no_configuration(tmp_path):
    came = await measured(
        tmp_path,
        "irb120-clean",
        """
        [[fault]]
        kind = "link_half_open"
        device = "tracker"
        reading = 4
        for_s = 2

        [[fault]]
        kind = "emergency_stop"
        configuration = 2
        after_s = 0.3
        for_s = 4

        [[fault]]
        kind = "link_cut"
        device = "tracker"
        configuration = 3
        for_s = 8

        [[fault]]
        kind = "robot_refuses"
        configuration = 4

        [[fault]]
        kind = "link_cut"
        device = "robot"
        configuration = 5
        for_s = 3

        [[fault]]
        kind = "tracker_repeats_result"
        configuration = 6

        [[fault]]
        kind = "tracker_stale_result"
        configuration = 7

        [[fault]]
        kind = "tracker_units_changed"
        configuration = 8

        [[fault]]
        kind = "tracker_cut"
        configuration = 9
        """,
        9,
    )

    assert came.skipped == {}
    assert came.configurations == list(range(1, 10))
    assert came.asked(
        "has stopped sending",
        "an emergency stop or motors off",
        "was lost: check power and cable",
        "check the pendant",
        "check the pendant",
        "earlier measurement",
        "changed the units",
        "was lost: check power and cable",
    )
    assert all(english(CELL_CLEAR) in question for question in came.questions)
    assert came.worst_mm < 0.15  # ten deviations of the tracker at that distance


async def test_what_moved_is_found_at_the_fixed_nests_and_a_broken_beam_leaves_a_configuration_out(tmp_path):
    came = await measured(
        tmp_path,
        "irb120-clean",
        """
        [[fault]]
        kind = "beam_broken"
        configuration = 2

        [[fault]]
        kind = "beam_broken"
        configuration = 3
        count = 3

        [[fault]]
        kind = "tripod_kicked"
        configuration = 4
        by_mm = [0.0, 0.4, 0.0]

        [[fault]]
        kind = "temperature_step"
        configuration = 6
        by_k = -4.0

        [[fault]]
        kind = "tool_slips"
        configuration = 6
        by_mm = [0.3, 0.0, 0.0]

        [[fault]]
        kind = "tracker_drifts"
        configuration = 9
        mm_per_h = [0.0, 0.0, 36.0]
        for_s = 30
        """,
        10,
        reference_every=4,
    )

    assert came.skipped.keys() == {3}
    assert "the beam was interrupted" in came.skipped[3]
    assert came.asked("by 0.3", "by 0.2")  # the kick, then the drift; no instrument sees the tool slip
    assert all("the tracker has moved" in question for question in came.questions)
    air_c = [point.temperature_c for point in came.points]
    assert np.mean(air_c[:4]) - np.mean(air_c[5:]) == pytest.approx(4.0, abs=0.3)  # the cell's own wave


@pytest.mark.parametrize(
    ("base", "protective", "emergency"),
    [
        ("ur10-clean", "it made a protective stop", "its emergency stop is pressed"),
        (
            "lrmate-fanuc",
            "the robot closed the connection during a motion",
            "the robot closed the connection during a motion",
        ),
    ],
)
async def test_a_stop_of_the_controller_is_for_a_person_to_release(tmp_path, base, protective, emergency):
    stop = """
        [[fault]]
        kind = "{}"
        configuration = {}
        after_s = 0.3
        for_s = 5
        """

    faults = stop.format("protective_stop", 1) + stop.format("emergency_stop", 2)
    came = await measured(tmp_path, base, faults, 2)

    assert came.configurations == [1, 2]
    assert came.asked(protective, emergency)
