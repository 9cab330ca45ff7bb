"""A ballbar session from start to end, and what becomes of it when something goes wrong."""

import asyncio
import math

import pytest

from tests.helpers.domain.asking import question
from tests.helpers.machine import HANGS_S
from tests.unit.service.sessions.ballbar.fakes import Bench, turns
from tests.unit.service.sessions.ballbar.sessions import CUP, LEG, NEXT_LEG, PLAN, POSE, joints, make_plan
from truepose.domain.ledger import EntryKind
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.errors import (
    NotNowError,
    PersonMissingError,
    PlanRefusedError,
    ReasonMissingError,
    WatchingTabletError,
)

NOISE_MM = 0.0006  # the wobble of the fake ballbar, in both readings that make a length


async def test_a_whole_session_is_done_by_doing_what_it_asks():
    async with Bench(PLAN) as bench:
        await bench.start()

        await bench.until(None)

        assert bench.now.state is SessionState.FINISHED
        assert {outcome.kind for outcome in bench.now.outcomes.values()} == {
            "confirmed",
            "measured",
            "moved",
            "computed",
        }
        assert bench.oracle.asked == 1
        assert await bench.running is SessionState.FINISHED


async def test_a_length_is_calibrator_plus_deviation_minus_zero_with_all_it_rests_on():
    async with Bench(PLAN).at(LEG) as bench:
        bench.hands.offset_mm = 0.1  # a zero that walked after the calibrator was read
        await bench.do()

        (entry,) = bench.kept(LEG)

        true_mm = 300.0 + bench.hands.deviation_mm - 0.002
        assert entry.length.length_mm == pytest.approx(true_mm, abs=NOISE_MM)
        assert entry.length.zero_mm == pytest.approx(0.002, abs=NOISE_MM)
        # reading, zero and calibrator: 0.51, 1.5 and 0.5 um
        assert entry.length.standard_uncertainty_mm == pytest.approx(0.00166, abs=1e-5)
        assert entry.length.initialisation == 3  # tool, base, pose 1
        assert not entry.length.by_hand
        assert entry.length.temperature_c == 22.5
        assert (entry.length.instrument_serial, entry.length.certificate) == ("B-7", "C-1")
        assert entry.length.certificate_expires == "2027-03-01"
        assert (entry.person, entry.tablet) == ("Eva", "one")


async def test_a_temperature_that_is_not_known_is_not_invented():
    async with Bench(PLAN) as bench:
        bench.bar.temperature_c = None
        await bench.start()
        await bench.do()

        (entry,) = bench.kept("tool/initialise")

        assert math.isnan(entry.length.temperature_c)


async def test_the_arm_moves_along_its_way_once_a_person_has_confirmed_and_not_before():
    async with Bench(PLAN).at(POSE) as bench:
        before = len(bench.robot.moves)
        await bench.clock.advance(30.0)
        assert len(bench.robot.moves) == before

        await bench.do()

        assert bench.robot.moves[before:] == [joints(1.5), joints(1)]
        assert bench.robot.limits.tool_speed_mm_s == PLAN.tool_speed_mm_s
        (moved,) = bench.kept(POSE, EntryKind.MOVED)
        assert moved.arrival.commanded_rad == joints(1)
        assert moved.arrival.direction[0] == -1  # the way came from 1.5


async def test_a_confirmation_that_was_under_way_for_long_moves_nothing():
    async with Bench(PLAN).at(CUP) as bench:
        seen_s = bench.clock.time_s
        await bench.clock.advance(2.5)

        with pytest.raises(NotNowError, match=r"2\.5 s"):
            await bench.press(CommandName.CONFIRM, seen_time_s=seen_s)

        await bench.clock.advance(5.0)
        assert bench.robot.moves == []


async def test_nothing_moves_on_an_old_statement_of_the_robot():
    async with Bench(PLAN).at(CUP) as bench:
        bench.robot.state_age_s = 2.5

        await bench.do()

        assert bench.robot.moves == []
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert "2.5 s old" in english(question(bench.runner))


async def test_the_same_connection_is_not_stored_twice_by_itself():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.do()
        assert bench.present == "tool/side-1-2"

        await bench.clock.advance(20.0)  # still on the calibrator

        assert bench.present == "tool/side-1-2"


async def test_nothing_is_stored_by_itself_while_the_length_moves():
    async with Bench(PLAN) as bench:
        await bench.start()
        bench.bar.wobble_mm = 0.02
        bench.hands.do_as_asked("tool/initialise")

        await bench.clock.advance(5.0)

        assert bench.present == "tool/initialise"
        bench.bar.wobble_mm = 0.0003
        await bench.clock.advance(0.5)
        assert bench.present == "tool/side-1-2"


async def test_nothing_is_stored_by_itself_once_the_arm_was_moved_by_others_and_the_stop_is_lost():
    async with Bench(PLAN).at(LEG) as bench:
        bench.robot.joints = (0.02, *bench.robot.joints[1:])
        bench.hands.do_as_asked(LEG)

        with pytest.raises(NotNowError, match="Joint 1"):
            await bench.press(CommandName.STORE)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert bench.kept(LEG) == []
        await bench.press(CommandName.CONFIRM)
        assert bench.present == "placement-1/pose-1/move/detach"


async def test_the_arm_that_is_moved_by_others_is_noticed_without_anybody_pressing_anything():
    async with Bench(PLAN).at(LEG) as bench:
        bench.robot.joints = (0.02, *bench.robot.joints[1:])

        await bench.clock.advance(1.0)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert bench.now.outcomes["placement-1/pose-1/leg-1-1"].kind == "open"


async def test_the_button_stores_what_is_shown():
    async with Bench(PLAN).at("tool/initialise") as bench:
        bench.hands.do_as_asked("tool/initialise")
        await bench.clock.advance(0.1)  # not long enough to be stored by itself

        outcome = await bench.press(CommandName.STORE)

        (entry,) = bench.kept("tool/initialise")
        assert entry.length.by_hand
        assert english(outcome.sentence) == "Stored: 150.0000 mm."


async def test_the_button_stores_nothing_that_was_shown_before_it_was_pressed():
    async with Bench(PLAN).at("tool/side-1-2") as bench:
        await bench.clock.advance(1.0)  # still on the calibrator
        bench.hands.do_as_asked("tool/side-1-2")

        await bench.press(CommandName.STORE)  # at once

        (entry,) = bench.kept("tool/side-1-2")
        assert entry.length.deviation_mm == pytest.approx(bench.hands.deviation_mm, abs=NOISE_MM)


async def test_the_button_does_not_wait_for_a_session_that_is_no_longer_run():
    async with Bench(PLAN).at("tool/initialise") as bench:
        bench.hands.do_as_asked("tool/initialise")
        pressed = asyncio.create_task(
            bench.runner.act(OperatorCommand(CommandName.STORE, "Eva", "one", "k", "tool/initialise"))
        )
        await turns()

        await bench.kill()

        with pytest.raises(NotNowError):
            await asyncio.wait_for(pressed, HANGS_S)
        assert bench.kept("tool/initialise") == []


async def test_a_repeated_request_is_done_once_and_answered_twice():
    async with Bench(PLAN).at("placement-1/place") as bench:
        answers = await asyncio.gather(
            bench.press(CommandName.CONFIRM, key="k"), bench.press(CommandName.CONFIRM, key="k")
        )

        assert answers[0] == answers[1]
        assert len(bench.kept("placement-1/place", EntryKind.CONFIRMED)) == 1
        assert bench.present == "placement-1/ball"


async def test_a_repeated_request_is_known_after_a_restart():
    async with Bench(PLAN).at("placement-1/place") as bench:
        first = await bench.press(CommandName.CONFIRM, key="k")
        await bench.restart()

        again = await bench.press(CommandName.CONFIRM, key="k", step_id="placement-1/place")

        assert again.entry == first.entry
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION  # the key confirmed nothing else


async def test_an_act_for_a_step_that_is_no_longer_there_does_nothing():
    async with Bench(PLAN).at("tool/side-1-2") as bench:
        before = len(bench.disk.entries)

        with pytest.raises(NotNowError, match="tool/side-1-2"):
            await bench.press(CommandName.SKIP, step_id="tool/initialise", reason="late")

        assert len(bench.disk.entries) == before


async def test_a_tablet_that_watches_may_stop_and_take_over_but_not_act():
    async with Bench(PLAN) as bench:
        await bench.start()
        for name in set(CommandName) - {CommandName.STOP, CommandName.HAND_OVER}:
            with pytest.raises(WatchingTabletError, match="Eva"):
                await bench.press(name, tablet="two", person="Ada")

        await bench.press(CommandName.HAND_OVER, tablet="two", person="Ada")

        assert (bench.now.acting.tablet, bench.now.acting.person) == ("two", "Ada")
        with pytest.raises(WatchingTabletError, match="Ada"):
            await bench.press(CommandName.RETRY)
        await bench.press(CommandName.STOP)
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION


async def test_an_act_needs_a_name_and_a_skip_its_reason():
    async with Bench(PLAN).at("tool/side-1-2") as bench:
        with pytest.raises(PersonMissingError):
            await bench.press(CommandName.SKIP, person=" ", reason="out of range")
        with pytest.raises(ReasonMissingError):
            await bench.press(CommandName.SKIP, reason=" ")


async def test_back_does_not_take_what_is_connected_for_what_is_asked_again():
    async with Bench(PLAN).at(NEXT_LEG) as bench:
        bench.hands.do_as_asked(NEXT_LEG)
        bench.suspect.blind = True
        await bench.clock.advance(0.1)

        await bench.press(CommandName.BACK)
        await bench.clock.advance(5.0)

        assert bench.present == LEG
        assert len(bench.kept(LEG)) == 1  # the one that was reopened


async def test_everybody_who_watches_sees_every_sample_at_twenty_hertz():
    async with Bench(PLAN) as bench:
        await bench.start()
        watchers = [bench.runner.live() for _ in range(3)]
        seen = [asyncio.create_task(_take(watcher, 20)) for watcher in watchers]
        await turns()

        await bench.clock.advance(1.0)

        samples = [task.result() for task in seen]
        assert samples[0] == samples[1] == samples[2]
        times = [sample.time_s for sample in samples[0]]
        assert times[-1] - times[0] == pytest.approx(0.95, abs=1e-6)
        assert samples[0][0].sampled_at_ms == pytest.approx(1000 * times[0], abs=1)


async def _take(watcher, number):
    samples = []
    async for sample in watcher:
        samples.append(sample)
        if len(samples) == number:
            break
    await watcher.aclose()
    return samples


async def test_a_plan_that_does_not_fit_is_refused_before_anything_happens():
    with pytest.raises(PlanRefusedError):
        Bench(make_plan((200,)))


async def test_a_session_that_never_began_can_be_ended():
    async with Bench(PLAN) as bench:
        await bench.press(CommandName.ABORT)

        assert await bench.running is SessionState.ABORTED
        assert bench.states() == [SessionState.ABORTED]
