"""A person says that the ballbar is off, or where it is; the samples say something else."""

import asyncio

import pytest

from tests.helpers.domain.asking import question
from tests.unit.service.sessions.ballbar.fakes import Bench
from tests.unit.service.sessions.ballbar.sessions import LEG, NEXT_LEG, PLAN, POSE, joints, make_plan
from truepose.domain.ledger import EntryKind
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.errors import NotNowError, ReasonMissingError
from truepose_drivers.errors import ConnectionLostError, NoReplyError

DETACH, MOVE = "placement-1/pose-1/detach", "placement-1/pose-2/move"
LAST_LEG = "placement-1/pose-1/leg-3-1"


async def test_the_word_that_the_ballbar_is_off_is_refused_while_it_reads_a_length():
    async with Bench(PLAN).at(DETACH) as bench:  # it is still where the last leg was read
        with pytest.raises(NotNowError, match="between two balls, or on the calibrator"):
            await bench.press(CommandName.CONFIRM)

        assert bench.now.attached
        bench.hands.detach()
        await bench.press(CommandName.CONFIRM)
        assert not bench.now.attached


@pytest.mark.parametrize("what", ["leg", "calibrator"])
async def test_a_motion_is_not_confirmed_while_the_ballbar_is_back_on(what):
    async with Bench(PLAN).at(MOVE) as bench:
        before = len(bench.robot.moves)
        bench.hands.connect(what, (1, 1))

        with pytest.raises(NotNowError, match="lay it down"):
            await bench.press(CommandName.CONFIRM)

        await bench.clock.advance(5.0)
        assert len(bench.robot.moves) == before


@pytest.mark.parametrize("beyond_mm", [None, 1.05], ids=["held in the hand", "run to its end"])
async def test_a_ballbar_that_was_seen_to_come_off_is_believed_to_be_off(beyond_mm):
    async with Bench(PLAN).at(DETACH) as bench:
        bench.hands.hold()
        bench.bar.out_of_range_mm = beyond_mm

        await bench.press(CommandName.CONFIRM)

        assert not bench.now.attached


async def test_a_ballbar_put_on_where_it_does_not_read_takes_a_reason_before_the_arm_moves():
    async with Bench(PLAN).at(MOVE) as bench:
        await bench.clock.advance(4.0)
        bench.hands.connect("leg", (1, 1))
        bench.bar.out_of_range_mm = 1.05

        with pytest.raises(ReasonMissingError, match="There is no evidence that the ballbar is off"):
            await bench.press(CommandName.CONFIRM)


async def test_a_leg_left_out_because_it_is_too_long_takes_a_reason_where_the_ballbar_stays_on():
    async with Bench(PLAN).at(LAST_LEG) as bench:
        bench.hands.connect("leg", (3, 1))
        bench.bar.out_of_range_mm = 1.05
        await bench.clock.advance(0.5)
        await bench.press(CommandName.SKIP, reason="too long")

        with pytest.raises(ReasonMissingError, match="There is no evidence that the ballbar is off"):
            await bench.press(CommandName.CONFIRM)

        bench.hands.hold()  # at its end it looks the same in the cups and on the table
        bench.bar.out_of_range_mm = None
        await bench.press(CommandName.CONFIRM)
        assert not bench.now.attached


@pytest.mark.parametrize("attached_later", [False, True], ids=["read before", "put on unseen"])
@pytest.mark.parametrize("lost", ["switched off", "cable", "frozen", "restart"])
async def test_no_motion_begins_while_the_ballbar_is_attached_and_cannot_be_read(lost, attached_later):
    """Whatever made it unreadable: switched off is no better than a cable that is out."""
    async with Bench(PLAN).at("placement-1/pose-1/initialise" if attached_later else DETACH) as bench:
        if attached_later:  # it was seen to be off; then it was put on, and what it does not read is skipped
            bench.hands.detach()
            await bench.clock.advance(0.5)
        await lose(bench, lost)
        if attached_later:
            bench.hands.connect("leg", (1, 1))
            await bench.press(CommandName.SKIP, reason="it reads nothing")
        assert bench.present == DETACH
        before = len(bench.robot.moves)

        for _ in range(3):
            with pytest.raises(ReasonMissingError, match="There is no evidence that the ballbar is off"):
                await bench.press(CommandName.CONFIRM)
            await bench.clock.advance(1.0)

        assert len(bench.robot.moves) == before


async def lose(bench: Bench, how: str) -> None:
    match how:
        case "switched off":
            bench.bar.switched_on = False
        case "cable":
            bench.bar.plugged = False
        case "frozen":
            bench.bar.frozen = True
        case _:
            bench.bar.switched_on = False
            await bench.restart()
            await bench.press(CommandName.CONFIRM)
    await bench.clock.advance(3.0)


async def test_what_a_person_said_does_not_outlive_the_next_length_that_is_asked_for():
    async with Bench(PLAN).at(DETACH) as bench:
        bench.bar.switched_on = False
        await bench.clock.advance(1.0)
        bench.hands.detach()
        await bench.press(CommandName.CONFIRM, reason="it lies on the table")
        await bench.do()  # the motion
        assert bench.present == "placement-1/pose-2/initialise"
        bench.hands.connect("leg", (1, 1))

        await bench.press(CommandName.SKIP, reason="it reads nothing")

        with pytest.raises(ReasonMissingError):
            await bench.press(CommandName.CONFIRM)


async def test_a_person_who_lays_the_ballbar_aside_is_never_asked_how_they_know():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until(None)

        confirmed = [entry for entry in bench.disk.entries if entry.kind is EntryKind.CONFIRMED]
        assert len(confirmed) > 5
        assert {entry.text for entry in confirmed} == {""}


@pytest.mark.parametrize("fault", [NoReplyError, ConnectionLostError])
async def test_a_link_that_is_lost_with_the_ballbar_on_takes_a_reason_that_is_kept(fault):
    async with Bench(PLAN).at(DETACH) as bench:
        bench.bar.lost, bench.bar.plugged = fault, False
        await bench.clock.advance(1.0)
        assert bench.runner._readings.sample.reason_needed

        with pytest.raises(ReasonMissingError, match="There is no evidence that the ballbar is off"):
            await bench.press(CommandName.CONFIRM)
        await bench.press(CommandName.CONFIRM, reason="its battery is out, it lies on the table")

        (entry,) = bench.kept(DETACH, EntryKind.CONFIRMED)
        assert entry.text == "its battery is out, it lies on the table"
        await bench.until(MOVE)
        await bench.do()  # the word counts for the motion too
        assert bench.robot.joints == joints(2)


async def test_a_link_that_is_lost_after_the_ballbar_was_seen_off_asks_for_nothing_more():
    async with Bench(PLAN).at(MOVE) as bench:
        await bench.clock.advance(1.0)
        bench.bar.plugged = False
        await bench.clock.advance(1.0)

        await bench.do()

        assert bench.robot.joints == joints(2)


async def test_a_count_that_stands_still_is_not_believed_and_nothing_of_it_is_stored():
    async with Bench(PLAN).at(LEG) as bench:
        bench.bar.frozen = True
        bench.hands.detach()
        await bench.clock.advance(2.0)

        assert bench.runner._readings.sample.state == "no_signal"
        with pytest.raises(NotNowError):
            await bench.press(CommandName.STORE)
        bench.bar.frozen = False
        await bench.until(DETACH)
        bench.bar.frozen = True
        await bench.clock.advance(2.0)
        with pytest.raises(ReasonMissingError):
            await bench.press(CommandName.CONFIRM)


async def test_after_a_restart_the_ledgers_word_is_not_enough_where_the_ballbar_is_back_on():
    async with Bench(PLAN).at(MOVE) as bench:
        before = len(bench.robot.moves)
        await bench.kill()
        bench.hands.connect("leg", (1, 1))
        await bench.restart()
        await bench.press(CommandName.CONFIRM)

        with pytest.raises(NotNowError, match="within its range"):
            await bench.press(CommandName.CONFIRM)

        assert len(bench.robot.moves) == before


async def test_after_a_restart_a_ballbar_that_cannot_be_read_takes_a_reason_once():
    async with Bench(PLAN).at(MOVE) as bench:
        bench.bar.plugged = False
        await bench.restart()
        await bench.press(CommandName.CONFIRM)

        with pytest.raises(ReasonMissingError):
            await bench.press(CommandName.CONFIRM)
        await bench.press(CommandName.CONFIRM, reason="it is in its box")
        await bench.clock.advance(5.0)

        assert bench.robot.joints == joints(2)


async def test_a_ballbar_put_on_while_the_arm_moves_has_nothing_more_sent_and_is_asked_off_again():
    plan = make_plan((1, 2), precalibrate_after=9, stable_s=0.2, settle_s=0.1)
    async with Bench(plan).at(POSE) as bench:
        before = len(bench.robot.moves)
        await bench.press(CommandName.CONFIRM)
        await bench.clock.advance(0.9)  # on the first piece of its way
        assert len(bench.robot.moves) == before + 1

        bench.hands.connect("calibrator")
        await bench.clock.advance(5.0)

        assert len(bench.robot.moves) == before + 1
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert "while the arm was moving" in english(question(bench.runner))
        assert bench.now.attached
        (again,) = bench.kept(f"{POSE}/detach", EntryKind.REOPENED)
        assert english(again.text) == "The ballbar read a length within its range."
        await bench.press(CommandName.CONFIRM)
        assert bench.present == f"{POSE}/detach"
        with pytest.raises(NotNowError):
            await bench.press(CommandName.CONFIRM)
        await bench.do()
        await bench.do()
        assert bench.robot.joints == joints(1)


async def test_a_ballbar_seen_on_during_the_last_piece_of_the_way_does_not_let_the_arm_arrive():
    async with Bench(PLAN).at(MOVE) as bench:
        await bench.press(CommandName.CONFIRM)
        while bench.robot.moves[-1] != joints(2):
            await bench.clock.advance(0.1)
        bench.hands.connect("leg", (1, 1))
        await bench.clock.advance(0.6)
        bench.hands.detach()  # torn off
        await bench.clock.advance(5.0)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert bench.kept(MOVE, EntryKind.MOVED) == []
        assert bench.now.attached


async def test_stop_while_the_ballbar_is_seen_on_keeps_both():
    async with Bench(PLAN).at(MOVE) as bench:
        await bench.press(CommandName.CONFIRM)
        await bench.clock.advance(0.5)
        bench.hands.connect("leg", (1, 1))
        await bench.press(CommandName.STOP)
        await bench.clock.advance(5.0)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert bench.now.attached


async def test_a_confirmation_of_a_motion_never_answers_another_question():
    """While the samples are awaited somebody presses STOP: what was confirmed is gone."""
    async with Bench(PLAN).at(MOVE) as bench:
        bench.hands.connect("leg", (1, 1))  # so that the samples are looked at for long
        before = len(bench.robot.moves)

        confirmed, _ = await asyncio.gather(
            bench.press(CommandName.CONFIRM), bench.press(CommandName.STOP), return_exceptions=True
        )

        assert isinstance(confirmed, NotNowError)
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert len(bench.robot.moves) == before


async def test_a_cup_is_not_clamped_on_record_where_the_arm_was_moved_since():
    async with Bench(PLAN).at("placement-1/cup-1/clamp") as bench:
        bench.robot.joints = (0.02, *bench.robot.joints[1:])

        with pytest.raises(NotNowError, match="does not count as clamped: Joint 1"):
            await bench.press(CommandName.CONFIRM)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION


# where the ballbar is


async def test_a_calibrator_that_is_stored_by_hand_as_a_leg_is_asked_about():
    async with Bench(PLAN).at("placement-1/pose-1/leg-1-1") as bench:
        bench.suspect.blind = True

        await bench.press(CommandName.STORE)  # the ballbar is where its zero was read

        assert bench.now.suspicion.suspicion.kind == "calibrator"
        assert bench.kept("placement-1/pose-1/leg-1-1") == []
        await bench.press(CommandName.ANSWER, answer="reconnected")
        await bench.press(CommandName.STORE)  # it was not, in truth
        assert bench.now.suspicion.suspicion.kind == "calibrator"


@pytest.mark.parametrize(
    ("step_id", "kind"),
    [
        ("tool/side-1-2", "like_calibrator"),
        ("placement-1/side-1-2", "calibrator"),
        (LEG, "calibrator"),
    ],
)
async def test_a_length_of_the_calibrator_is_asked_about_though_the_ballbar_was_let_go(step_id, kind):
    async with Bench(PLAN).at(step_id) as bench:
        bench.suspect.blind = True
        bench.hands.detach()
        await bench.clock.advance(0.3)
        bench.hands.connect("calibrator")
        await bench.clock.advance(2.0)

        assert bench.kept(step_id) == []
        assert bench.now.suspicion.suspicion.kind == kind
        await bench.press(CommandName.ANSWER, answer="right_pair")
        (entry,) = bench.kept(step_id)
        assert entry.suspicion.kind == kind


@pytest.mark.parametrize(("first", "second"), [("tool/side-1-2", "tool/side-2-3"), (LEG, NEXT_LEG)])
async def test_a_connection_that_was_read_already_is_asked_about_when_it_is_stored_by_hand(first, second):
    async with Bench(PLAN).at(first) as bench:
        bench.suspect.blind = True
        await bench.do()
        assert bench.present == second

        await bench.press(CommandName.STORE)

        assert bench.kept(second) == []
        assert bench.now.suspicion.suspicion.kind == "same_connection"
        assert bench.now.suspicion.suspicion.suspected == ((1, 2) if second == NEXT_LEG else None)


async def test_what_is_said_to_be_connected_anew_and_was_not_let_go_is_asked_about_again():
    async with Bench(PLAN).at("tool/side-2-3") as bench:
        await bench.press(CommandName.STORE)
        await bench.press(CommandName.ANSWER, answer="reconnected")

        await bench.press(CommandName.STORE)

        assert bench.now.suspicion.suspicion.kind == "same_connection"


async def test_retry_does_not_store_by_itself_what_is_connected_for_another_step():
    async with Bench(PLAN).at("tool/side-2-3") as bench:
        await bench.press(CommandName.RETRY)
        await bench.clock.advance(5.0)

        assert bench.present == "tool/side-2-3"
        assert bench.now.suspicion is None


async def test_retry_after_back_reads_the_same_connection_again():
    async with Bench(PLAN).at("tool/side-2-3") as bench:
        await bench.press(CommandName.BACK)
        assert bench.present == "tool/side-1-2"

        await bench.press(CommandName.RETRY)
        await bench.clock.advance(2.0)

        assert len(bench.kept("tool/side-1-2")) == 2


async def test_after_a_restart_it_is_still_known_what_was_connected():
    async with Bench(PLAN).at("placement-1/pose-1/leg-1-1") as bench:
        await bench.restart()
        await bench.press(CommandName.CONFIRM)

        await bench.press(CommandName.STORE)

        assert bench.now.suspicion.suspicion.kind == "calibrator"


async def test_a_zero_read_off_the_calibrator_is_asked_about_and_the_zero_walks_a_little():
    async with Bench(PLAN).at("placement-1/pose-1/initialise") as bench:
        bench.hands.offset_mm = 0.003  # as far as the snaps let it walk
        await bench.do()
        assert bench.now.suspicion is None

        await bench.until("placement-1/pose-2/initialise")
        bench.hands.offset_mm = 0.011
        await bench.do()

        assert bench.now.suspicion.suspicion.kind == "not_calibrator"
        assert bench.now.suspicion.suspicion.length_mm == pytest.approx(300.008, abs=0.001)


async def test_bars_that_were_not_changed_show_in_the_zero():
    async with Bench(PLAN).at("placement-1/initialise") as bench:
        bench.hands.connect("calibrator")  # with the bars of the tool triangle
        bench.hands.bars = "tool"
        await bench.clock.advance(2.0)

        assert bench.now.suspicion.suspicion.kind == "same_bars"
        assert bench.kept("placement-1/initialise") == []


async def test_a_zero_after_a_lost_supply_is_not_taken_from_the_leg_that_is_connected():
    async with Bench(PLAN).at(NEXT_LEG) as bench:
        await bench.replug()
        assert bench.present == f"{NEXT_LEG}/initialise"

        await bench.press(CommandName.RETRY)
        await bench.clock.advance(3.0)
        assert bench.kept(f"{NEXT_LEG}/initialise") == []
        await bench.press(CommandName.STORE)

        assert bench.now.suspicion.suspicion.kind == "not_calibrator"
        await bench.press(CommandName.ANSWER, answer="reconnected")
        await bench.do()
        assert bench.present == NEXT_LEG


@pytest.mark.parametrize(
    ("bar", "state", "says"),
    [
        ({"plugged": False}, "no_signal", "no signal"),
        ({"switched_on": False}, "no_signal", "no signal"),
        ({"out_of_range_mm": -1.1}, "out_low", "too close"),
        ({"out_of_range_mm": 1.1}, "out_high", "too far"),
        ({"wobble_mm": 0.02}, "unstable", "still changing"),
    ],
)
async def test_the_button_is_refused_and_the_page_knows_it_beforehand(bar, state, says):
    async with Bench(PLAN).at("tool/initialise") as bench:
        bench.hands.do_as_asked("tool/initialise")
        for name, value in bar.items():
            setattr(bench.bar, name, value)
        await bench.clock.advance(0.2)
        sample = bench.runner._readings.sample

        assert (sample.state, sample.can_store, sample.why_not) == (state, False, state)
        with pytest.raises(NotNowError, match=says):
            await bench.press(CommandName.STORE)
        assert bench.kept("tool/initialise") == []


async def test_the_page_knows_when_a_length_can_be_stored_and_whether_it_was_let_go():
    async with Bench(PLAN).at("tool/initialise") as bench:
        bench.hands.do_as_asked("tool/initialise")
        await bench.clock.advance(0.1)
        sample = bench.runner._readings.sample
        assert (sample.can_store, sample.why_not, sample.let_go) == (True, None, True)

        await bench.until("tool/side-1-2")
        await bench.clock.advance(0.3)
        assert (bench.runner._readings.sample.can_store, bench.runner._readings.sample.let_go) == (
            True,
            False,
        )
        await bench.until("tool/detach")
        await bench.clock.advance(0.1)
        assert bench.runner._readings.sample.why_not == "no_length_here"


async def test_a_mistake_of_the_program_has_the_session_await_a_person_and_go_on_by_an_act():
    async with Bench(PLAN).at(LEG) as bench:

        async def fails():
            raise ValueError("no langid")

        read, bench.bar.read = bench.bar.read, fails
        await bench.clock.advance(0.2)
        with pytest.raises(ValueError, match="no langid"):
            await bench.running

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert "ValueError" in english(question(bench.runner))
        bench.bar.read = read
        await bench.restart()
        await bench.press(CommandName.CONFIRM)
        await bench.until(None)
