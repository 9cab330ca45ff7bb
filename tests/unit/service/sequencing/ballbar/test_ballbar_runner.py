"""A ballbar session from start to end, and what becomes of it when something goes wrong."""

import asyncio
import math
from dataclasses import replace

import pytest

from tests.unit.service.sequencing.ballbar.fakes import Bench, turns
from tests.unit.service.sequencing.ballbar.sessions import LEGS, found, joints, make_plan, make_pose
from truepose.domain.ballbar import PoseForecast, Suspicion
from truepose.domain.errors import ConfigurationError, UnderdeterminedError
from truepose.domain.ledger import EntryKind
from truepose.domain.session import SessionState
from truepose.sequencing.ballbar.doubts.assignments import Judges
from truepose.sequencing.engine.acts import Act, ActName
from truepose.sequencing.errors import (
    NotNowError,
    PersonMissingError,
    PlanRefusedError,
    ReasonMissingError,
    WatchingTabletError,
)
from truepose_drivers.errors import ConnectionLostError, NoReplyError, TargetRefusedError

PLAN = make_plan((1, 2), precalibrate_after=1, stable_s=0.2, settle_s=0.1)
LEG = "placement-1/pose-1/leg-1-2"
CUP = "placement-1/cup-1/move"
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
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(LEG)
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
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("placement-1/pose-1/move")
        before = len(bench.robot.moves)
        await bench.clock.advance(30.0)
        assert len(bench.robot.moves) == before

        await bench.do()

        assert bench.robot.moves[before:] == [joints(1.5), joints(1)]
        assert bench.robot.limits.tool_speed_mm_s == PLAN.tool_speed_mm_s
        (moved,) = bench.kept("placement-1/pose-1/move", EntryKind.MOVED)
        assert moved.arrival.commanded_rad == joints(1)
        assert moved.arrival.direction[0] == -1  # the way came from 1.5


async def test_a_confirmation_that_was_under_way_for_long_moves_nothing():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(CUP)
        seen_s = bench.clock.time_s
        await bench.clock.advance(2.5)

        with pytest.raises(NotNowError, match=r"2\.5 s"):
            await bench.press(ActName.CONFIRM, seen_time_s=seen_s)

        await bench.clock.advance(5.0)
        assert bench.robot.moves == []


async def test_nothing_moves_on_an_old_statement_of_the_robot():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(CUP)
        bench.robot.state_age_s = 2.5

        await bench.do()

        assert bench.robot.moves == []
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert "2.5 s old" in bench.runner.question


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
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(LEG)
        bench.robot.joints = (0.02, *bench.robot.joints[1:])
        bench.hands.do_as_asked(LEG)

        with pytest.raises(NotNowError, match="Joint 1"):
            await bench.press(ActName.STORE)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert bench.kept(LEG) == []
        await bench.press(ActName.CONFIRM)
        assert bench.present == "placement-1/pose-1/move/detach"


async def test_the_arm_that_is_moved_by_others_is_noticed_without_anybody_pressing_anything():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(LEG)
        bench.robot.joints = (0.02, *bench.robot.joints[1:])

        await bench.clock.advance(1.0)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert bench.now.outcomes["placement-1/pose-1/leg-1-1"].kind == "open"


async def test_the_button_stores_what_is_shown():
    async with Bench(PLAN) as bench:
        await bench.start()
        bench.hands.do_as_asked("tool/initialise")
        await bench.clock.advance(0.1)  # not long enough to be stored by itself

        outcome = await bench.press(ActName.STORE)

        (entry,) = bench.kept("tool/initialise")
        assert entry.length.by_hand
        assert outcome.sentence == "Stored: 150.0000 mm."


async def test_the_button_stores_nothing_that_was_shown_before_it_was_pressed():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("tool/side-1-2")
        await bench.clock.advance(1.0)  # still on the calibrator
        bench.hands.do_as_asked("tool/side-1-2")

        await bench.press(ActName.STORE)  # at once

        (entry,) = bench.kept("tool/side-1-2")
        assert entry.length.deviation_mm == pytest.approx(bench.hands.deviation_mm, abs=NOISE_MM)


async def test_the_button_does_not_wait_for_a_session_that_is_no_longer_run():
    async with Bench(PLAN) as bench:
        await bench.start()
        bench.hands.do_as_asked("tool/initialise")
        pressed = asyncio.create_task(
            bench.runner.act(Act(ActName.STORE, "Eva", "one", "k", "tool/initialise"))
        )
        await turns()

        await bench.kill()

        with pytest.raises(NotNowError):
            await asyncio.wait_for(pressed, 10.0)
        assert bench.kept("tool/initialise") == []


@pytest.mark.parametrize(("shown_mm", "says"), [(-1.1, "too close"), (1.1, "too far"), (None, "no signal")])
async def test_the_button_stores_nothing_where_there_is_no_length(shown_mm, says):
    async with Bench(PLAN) as bench:
        await bench.start()
        if shown_mm is not None:
            bench.hands.do_as_asked("tool/initialise")
            bench.bar.out_of_range_mm = shown_mm
        await bench.clock.advance(0.5)

        with pytest.raises(NotNowError, match=says):
            await bench.press(ActName.STORE)

        assert bench.kept("tool/initialise") == []


async def test_a_repeated_request_is_done_once_and_answered_twice():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("placement-1/place")

        answers = await asyncio.gather(
            bench.press(ActName.CONFIRM, key="k"), bench.press(ActName.CONFIRM, key="k")
        )

        assert answers[0] == answers[1]
        assert len(bench.kept("placement-1/place", EntryKind.CONFIRMED)) == 1
        assert bench.present == "placement-1/ball"


async def test_a_repeated_request_is_known_after_a_restart():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("placement-1/place")
        first = await bench.press(ActName.CONFIRM, key="k")
        await bench.restart()

        again = await bench.press(ActName.CONFIRM, key="k", step_id="placement-1/place")

        assert again.entry == first.entry
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION  # the key confirmed nothing else


async def test_an_act_for_a_step_that_is_no_longer_there_does_nothing():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("tool/side-1-2")
        before = len(bench.disk.entries)

        with pytest.raises(NotNowError, match="tool/side-1-2"):
            await bench.press(ActName.SKIP, step_id="tool/initialise", reason="late")

        assert len(bench.disk.entries) == before


async def test_a_tablet_that_watches_may_stop_and_take_over_but_not_act():
    async with Bench(PLAN) as bench:
        await bench.start()
        for name in set(ActName) - {ActName.STOP, ActName.HAND_OVER}:
            with pytest.raises(WatchingTabletError, match="Eva"):
                await bench.press(name, tablet="two", person="Ada")

        await bench.press(ActName.HAND_OVER, tablet="two", person="Ada")

        assert (bench.now.acting.tablet, bench.now.acting.person) == ("two", "Ada")
        with pytest.raises(WatchingTabletError, match="Ada"):
            await bench.press(ActName.RETRY)
        await bench.press(ActName.STOP)
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION


async def test_an_act_needs_a_name_and_a_skip_its_reason():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("tool/side-1-2")

        with pytest.raises(PersonMissingError):
            await bench.press(ActName.SKIP, person=" ", reason="out of range")
        with pytest.raises(ReasonMissingError):
            await bench.press(ActName.SKIP, reason=" ")


async def test_a_wrong_connection_is_asked_about_and_never_stored_silently():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(LEG)
        bench.hands.connect("leg", (2, 3))

        await bench.clock.advance(2.0)

        assert bench.kept(LEG) == []
        assert bench.now.suspicion.suspicion.suspected == (2, 3)
        await bench.press(ActName.ANSWER, answer="reconnected")
        await bench.clock.advance(2.0)  # it was not, in truth
        assert bench.kept(LEG) == []
        bench.hands.do_as_asked(LEG)
        await bench.clock.advance(1.0)
        assert len(bench.kept(LEG)) == 1


async def test_the_same_pair_twice_is_recognised_from_the_lengths_alone():
    async with Bench(PLAN, judges=Judges()) as bench:
        await bench.start()
        await bench.until(LEG)
        bench.hands.detach()
        await bench.clock.advance(0.2)
        bench.hands.connect("leg", (1, 1))  # again

        await bench.clock.advance(1.0)

        assert bench.kept(LEG) == []
        assert bench.now.suspicion.suspicion.kind == "same_pair"
        assert bench.now.suspicion.suspicion.suspected == (1, 1)


async def test_what_cannot_be_judged_is_asked_about():
    def at_a_loss(*_, **__):
        raise ConfigurationError("The forecast does not know this leg.")

    async with Bench(PLAN, judges=Judges(leg=at_a_loss)) as bench:
        await bench.start()
        await bench.until("placement-1/side-1-2")

        await bench.do()

        assert bench.now.suspicion.suspicion.kind == "unlikely"
        assert bench.kept("placement-1/side-1-2") == []


async def test_a_doubt_that_the_person_denies_is_stored_with_the_answer():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(LEG)
        bench.hands.connect("leg", (2, 3))
        await bench.clock.advance(2.0)
        bench.hands.detach()  # the reading is the one that was taken, whatever is connected now
        await bench.clock.advance(0.5)

        await bench.press(ActName.ANSWER, answer="right_pair")

        (entry,) = bench.kept(LEG)
        (doubt,) = bench.kept(LEG, EntryKind.SUSPECTED)
        assert entry.length == doubt.length
        assert entry.suspicion == doubt.suspicion
        assert entry.text == "right_pair"


async def test_a_leg_that_was_read_of_another_pair_is_read_again_once_that_pair_comes():
    first = "placement-1/pose-1/leg-1-1"
    async with Bench(PLAN, judges=Judges()) as bench:
        await bench.start()
        await bench.until(first)
        await bench.clear_hands(first)
        bench.hands.connect("leg", LEGS[1])  # taken for the first one: nobody can see that
        await bench.clock.advance(1.0)
        await bench.do()  # as asked for: the pair that was read before
        assert bench.now.suspicion.suspicion.kind == "same_pair"

        await bench.press(ActName.ANSWER, answer="right_pair")

        assert len(bench.kept(LEG)) == 1
        assert bench.present == first
        assert bench.now.outcomes[first].length is None


async def test_two_pairs_of_one_length_are_read_again_once_at_most():
    first = "placement-1/pose-1/leg-1-1"
    async with Bench(PLAN, judges=Judges()) as bench:
        await bench.start()
        await bench.until(first)
        for step_id in (first, LEG, first):
            await bench.clear_hands(step_id)
            bench.hands.connect("leg", LEGS[1])
            await bench.clock.advance(1.0)
            if bench.now.suspicion is not None:
                await bench.press(ActName.ANSWER, answer="right_pair")

        assert bench.now.outcomes[first].length is not None
        assert bench.now.outcomes[LEG].length is not None
        assert bench.present == "placement-1/pose-1/leg-2-1"


@pytest.mark.parametrize("suspected", [(3, 3), None])
async def test_an_earlier_leg_that_is_meant_by_a_doubt_is_read_again_and_no_other(suspected):
    async with Bench(PLAN) as bench:
        await bench.start()
        bench.oracle.answer = found(make_pose(2), forecasts=(_forecast(2),))
        await bench.until("placement-1/pose-2/leg-3-1")
        bench.suspect.of_pose = (Suspicion("other_pair", (1, 1), suspected, 300.1, 300.2),)
        await bench.do()

        await bench.press(ActName.ANSWER, answer="reconnected")

        assert bench.present == "placement-1/pose-2/leg-1-1"
        assert bench.now.outcomes["placement-1/pose-2/initialise"].kind == "measured"
        assert bench.now.outcomes["placement-1/pose-2/leg-1-2"].kind == "measured"


async def test_an_answer_that_is_none_is_refused():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(LEG)
        bench.hands.connect("leg", (2, 3))
        await bench.clock.advance(2.0)

        with pytest.raises(NotNowError, match="right_pair"):
            await bench.press(ActName.ANSWER, answer="maybe")


async def test_legs_that_were_exchanged_are_both_read_again():
    async with Bench(PLAN) as bench:
        await bench.start()
        forecast = found(make_pose(2), forecasts=(_forecast(2),))
        bench.oracle.answer = forecast
        await bench.until("placement-1/pose-2/leg-3-1")
        bench.suspect.of_pose = (Suspicion("exchanged", (1, 1), (2, 2), 300.1, 300.2),)
        await bench.do()
        assert bench.now.suspicion is not None

        await bench.press(ActName.ANSWER, answer="reconnected")

        kinds = {
            name[-3:]: outcome.kind for name, outcome in bench.now.outcomes.items() if "pose-2/leg" in name
        }
        assert {pair for pair, kind in kinds.items() if kind == "open"} == {"1-1", "2-2", "3-1"}
        assert bench.present == "placement-1/pose-2/leg-1-1"


def _forecast(config):
    covariance = tuple(tuple(1e-3 * (i == j) for j in range(6)) for i in range(6))
    return PoseForecast(config, LEGS, (300.0,) * 6, covariance)


async def test_a_calibrator_that_is_far_from_where_it_was_is_doubted():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("placement-1/pose-1/initialise")
        bench.hands.connect("leg", (1, 1))  # not the calibrator
        bench.suspect.blind = True

        await bench.clock.advance(2.0)

        assert bench.now.suspicion.suspicion.kind == "not_calibrator"
        assert bench.kept("placement-1/pose-1/initialise") == []


@pytest.mark.parametrize(
    ("fault", "first"), [(NoReplyError, LEG), (ConnectionLostError, f"{LEG}/initialise")]
)
async def test_a_pulled_cable_is_shown_and_the_session_goes_on_when_it_is_back(fault, first):
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(LEG)
        bench.bar.lost = fault
        bench.bar.plugged = False
        await bench.clock.advance(3.0)
        assert bench.runner._readings.sample.state == "no_signal"
        assert bench.now.state is SessionState.RUNNING

        bench.bar.plugged = True
        await bench.clock.advance(5.0)  # the longest wait before the next attempt is 4 s

        assert bench.runner._readings.sample.state == "in_range"
        assert bench.present == first  # a gauge without supply has lost its zero, a silent counter has not
        await bench.until("placement-1/pose-1/leg-2-1")
        (entry,) = bench.kept(LEG)
        assert entry.length.initialisation == (3 if first == LEG else 4)


async def test_a_robot_that_is_gone_has_the_session_await_a_person_and_go_on():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(LEG)
        bench.robot.plugged = False
        await bench.clock.advance(1.0)
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        await bench.press(ActName.CONFIRM)
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION  # it is still gone

        bench.robot.plugged = True
        await bench.press(ActName.CONFIRM)

        await bench.until(None)
        assert bench.now.state is SessionState.FINISHED


@pytest.mark.parametrize("fault", [ConnectionLostError("cut"), TargetRefusedError("joint 3")])
async def test_a_motion_that_fails_is_asked_for_again(fault):
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(CUP)
        bench.robot.fault = fault

        await bench.do()

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        await bench.press(ActName.CONFIRM)
        assert bench.present == CUP
        assert not bench.now.confirmed
        await bench.do()
        assert bench.present == "placement-1/cup-1/clamp"


@pytest.mark.parametrize(
    ("name", "state"),
    [
        (ActName.PAUSE, SessionState.PAUSED),
        (ActName.STOP, SessionState.AWAITING_CONFIRMATION),
        (ActName.ABORT, SessionState.ABORTED),
    ],
)
async def test_a_halt_during_a_motion_lets_it_end_and_sends_nothing_more(name, state):
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("placement-1/pose-1/move")
        before = len(bench.robot.moves)
        await bench.press(ActName.CONFIRM)
        await bench.clock.advance(0.5)
        assert bench.runner.robot_moving

        outcome = await bench.press(name)
        await bench.clock.advance(5.0)

        assert "ends first" in outcome.sentence
        assert bench.robot.moves[before:] == [joints(1.5)]  # not on to the target
        assert bench.now.state is state


async def test_a_way_on_which_the_arm_was_halted_is_gone_on_with_from_there():
    stops = (joints(5), joints(6), joints(7))
    plan = make_plan((1, 2), settle_s=0.1)
    (place,) = plan.placements
    poses = (make_pose(1, via_rad=stops), *place.poses[1:])
    async with Bench(replace(plan, placements=(replace(place, poses=poses),))) as bench:
        await bench.start()
        await bench.until("placement-1/pose-1/move")
        before = len(bench.robot.moves)
        await bench.press(ActName.CONFIRM)
        while len(bench.robot.moves) < before + 2:
            await bench.clock.advance(0.1)
        await bench.press(ActName.STOP)
        await bench.clock.advance(2.0)

        await bench.press(ActName.CONFIRM)
        await bench.do()

        assert bench.robot.moves[before:] == [*stops, joints(1)]


async def test_a_halt_that_is_asked_for_while_a_motion_is_being_confirmed_comes_first():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("placement-1/cup-2/move")  # nothing keeps this motion from beginning at once
        before = list(bench.robot.moves)

        confirmed, _ = await asyncio.gather(
            bench.press(ActName.CONFIRM), bench.press(ActName.STOP), return_exceptions=True
        )
        await bench.clock.advance(5.0)

        assert isinstance(confirmed, NotNowError)  # it was of the motion, not of what is asked since
        assert bench.robot.moves == before
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION


async def test_after_a_pause_the_cell_is_looked_at_again():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(CUP)
        await bench.press(ActName.PAUSE)

        await bench.press(ActName.RESUME)
        await bench.clock.advance(5.0)

        assert bench.robot.moves == []
        assert bench.present == CUP
        await bench.do()
        assert bench.present == "placement-1/cup-1/clamp"


async def test_after_a_restart_the_same_step_is_there_and_nothing_moves_before_a_person_confirms():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("placement-1/pose-1/move")
        await bench.press(ActName.CONFIRM)
        await bench.clock.advance(0.5)
        before = list(bench.robot.moves)

        await bench.restart()
        await bench.clock.advance(10.0)

        assert bench.present == "placement-1/pose-1/move"
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert bench.robot.moves == before
        await bench.press(ActName.CONFIRM)
        await bench.clock.advance(10.0)
        assert bench.robot.moves == before  # that was the session, not the motion
        await bench.until(None)


async def test_every_reading_survives_a_restart_at_every_step():
    async with Bench(PLAN) as bench:
        await bench.start()
        while bench.present is not None:
            await bench.do()
            if bench.present is None:
                break
            step_id, measured = bench.present, bench.now.progress.readings
            await bench.restart()
            assert (bench.present, bench.now.progress.readings) == (step_id, measured)
            await bench.press(ActName.CONFIRM)

        assert bench.now.state is SessionState.FINISHED
        assert all(len(bench.kept(step.id)) <= 1 for step in bench.now.steps)


async def test_an_arm_that_was_moved_while_the_program_was_off_loses_its_stop():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(LEG)
        await bench.kill()
        bench.robot.joints = joints(7)
        await bench.restart()

        await bench.press(ActName.CONFIRM)

        assert bench.present == "placement-1/pose-1/move/detach"
        assert bench.now.outcomes["placement-1/pose-1/leg-1-1"].kind == "open"


async def test_a_pre_calibration_that_fails_pauses_and_can_be_tried_again_or_left_out():
    async with Bench(PLAN) as bench:
        bench.oracle.answer = UnderdeterminedError("Six legs are too few.")
        await bench.start()
        while bench.now.state is SessionState.RUNNING:
            await bench.do()
        assert bench.now.state is SessionState.PAUSED
        assert "Six legs are too few." in bench.runner.question
        assert bench.present == "placement-1/precalibrate-1"

        await bench.press(ActName.RESUME)
        await bench.clock.advance(0.1)
        assert bench.oracle.asked == 2
        await bench.press(ActName.SKIP, reason="no time")
        await bench.press(ActName.RESUME)

        assert bench.present == "placement-1/pose-2/move"


async def test_what_is_wrong_with_a_pre_calibration_is_no_reason_to_lose_the_session():
    async with Bench(PLAN) as bench:
        bench.oracle.answer = found(make_pose(2, legs=((1, 1),)))
        await bench.start()

        while bench.now.state is SessionState.RUNNING:
            await bench.do()

        assert "Configuration 2 has 1 legs" in bench.runner.question


async def test_a_pose_to_which_no_clear_way_was_found_is_left_out_with_the_reason():
    async with Bench(make_plan((1, 2, 3), precalibrate_after=1, stable_s=0.2, settle_s=0.1)) as bench:
        bench.oracle.answer = found(make_pose(3))
        await bench.start()

        await bench.until(None)

        left_out = bench.now.outcomes["placement-1/pose-2/leg-1-1"]
        assert (left_out.kind, left_out.text) == (
            "skipped",
            "The pre-calibration found no clear way to this pose.",
        )
        assert joints(2) not in bench.robot.moves
        assert bench.now.outcomes["placement-1/pose-3/leg-1-1"].kind == "measured"


async def test_the_end_does_not_wait_for_a_pre_calibration():
    async with Bench(PLAN) as bench:
        bench.oracle.clock, bench.oracle.duration_s = bench.clock, 1000.0
        await bench.start()
        await bench.until("placement-1/precalibrate-1")
        await bench.clock.advance(1.0)

        await bench.press(ActName.ABORT)
        await bench.clock.advance(1.0)

        assert await bench.running is SessionState.ABORTED


async def test_back_does_not_take_what_is_connected_for_what_is_asked_again():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("placement-1/pose-1/leg-2-1")
        bench.hands.do_as_asked("placement-1/pose-1/leg-2-1")
        bench.suspect.blind = True
        await bench.clock.advance(0.1)

        await bench.press(ActName.BACK)
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
        await bench.press(ActName.ABORT)

        assert await bench.running is SessionState.ABORTED
        assert bench.states() == [SessionState.ABORTED]
