"""Lengths that a session doubts, and what becomes of them."""

import pytest

from tests.unit.service.sessions.ballbar.fakes import Bench
from tests.unit.service.sessions.ballbar.sessions import LEG, LEGS, NEXT_LEG, PLAN, found, make_pose
from truepose.domain.ballbar import PoseForecast, Suspicion
from truepose.domain.errors import ConfigurationError
from truepose.domain.ledger import EntryKind
from truepose.sessions.ballbar.length_check import Judges
from truepose.sessions.ballbar.state import Answer
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.errors import (
    NotNowError,
)

FIRST_LEG = "placement-1/pose-1/leg-1-1"


async def test_a_wrong_connection_is_asked_about_and_never_stored_silently():
    async with Bench(PLAN).at(LEG) as bench:
        bench.hands.connect("leg", (2, 3))

        await bench.clock.advance(2.0)

        assert bench.kept(LEG) == []
        assert bench.now.suspicion.suspicion.suspected == (2, 3)
        await bench.press(CommandName.ANSWER, answer="reconnected")
        await bench.clock.advance(2.0)  # it was not, in truth
        assert bench.kept(LEG) == []
        bench.hands.do_as_asked(LEG)
        await bench.clock.advance(1.0)
        assert len(bench.kept(LEG)) == 1


@pytest.mark.parametrize(
    ("side", "kind", "main"),
    [
        ("tool/side-1-2", "like_calibrator", Answer.RIGHT_PAIR),  # made to the calibrator's length
        ("placement-1/side-1-2", "calibrator", Answer.RECONNECTED),
    ],
)
async def test_a_length_of_the_calibrator_is_asked_about_once_for_each_step(side, kind, main):
    async with Bench(PLAN).at(side) as bench:
        bench.suspect.blind = True
        for doubts in (1, 0):
            bench.hands.detach()
            await bench.clock.advance(0.5)
            bench.hands.connect("calibrator")  # a side that is as long
            await bench.clock.advance(2.0)
            assert len(bench.kept(side)) == 1 - doubts
            if doubts:
                asked = bench.now.suspicion
                assert (asked.suspicion.kind, asked.main_answer) == (kind, main)
                await bench.press(CommandName.ANSWER, answer="reconnected")

        assert len(bench.kept(side, EntryKind.SUSPECTED)) == 1


async def test_an_answer_that_led_nowhere_twice_is_not_the_main_one():
    side, offered = "placement-1/side-1-2", []
    async with Bench(PLAN).at(side) as bench:
        await bench.clear_hands(side)
        bench.hands.connect("calibrator")
        await bench.clock.advance(2.0)
        for _ in range(3):
            offered.append(bench.now.suspicion.main_answer)
            await bench.press(CommandName.ANSWER, answer="reconnected")
            await bench.press(CommandName.STORE)

    assert offered == [Answer.RECONNECTED, Answer.RECONNECTED, Answer.RIGHT_PAIR]


async def test_the_same_pair_twice_is_recognised_from_the_lengths_alone():
    async with Bench(PLAN, judges=Judges()).at(LEG) as bench:
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

    async with Bench(PLAN, judges=Judges(leg=at_a_loss)).at("placement-1/side-1-2") as bench:
        await bench.do()

        assert bench.now.suspicion.suspicion.kind == "unlikely"
        assert bench.kept("placement-1/side-1-2") == []


async def test_a_doubt_that_the_person_denies_is_stored_with_the_answer():
    async with Bench(PLAN).at(LEG) as bench:
        bench.hands.connect("leg", (2, 3))
        await bench.clock.advance(2.0)
        bench.hands.detach()  # the reading is the one that was taken, whatever is connected now
        await bench.clock.advance(0.5)

        await bench.press(CommandName.ANSWER, answer="right_pair")

        (entry,) = bench.kept(LEG)
        (doubt,) = bench.kept(LEG, EntryKind.SUSPECTED)
        assert entry.length == doubt.length
        assert entry.suspicion == doubt.suspicion
        assert entry.text == "right_pair"


async def test_a_leg_that_was_read_of_another_pair_is_read_again_once_that_pair_comes():
    async with Bench(PLAN, judges=Judges()).at(FIRST_LEG) as bench:
        await bench.clear_hands(FIRST_LEG)
        bench.hands.connect("leg", LEGS[1])  # taken for the first one: nobody can see that
        await bench.clock.advance(1.0)
        await bench.do()  # as asked for: the pair that was read before
        assert bench.now.suspicion.suspicion.kind == "same_pair"

        await bench.press(CommandName.ANSWER, answer="right_pair")

        assert len(bench.kept(LEG)) == 1
        assert bench.present == FIRST_LEG
        assert bench.now.outcomes[FIRST_LEG].length is None


async def test_two_pairs_of_one_length_are_read_again_once_at_most():
    async with Bench(PLAN, judges=Judges()).at(FIRST_LEG) as bench:
        for step_id in (FIRST_LEG, LEG, FIRST_LEG):
            await bench.clear_hands(step_id)
            bench.hands.connect("leg", LEGS[1])
            await bench.clock.advance(1.0)
            if bench.now.suspicion is not None:
                await bench.press(CommandName.ANSWER, answer="right_pair")

        assert bench.now.outcomes[FIRST_LEG].length is not None
        assert bench.now.outcomes[LEG].length is not None
        assert bench.present == NEXT_LEG


@pytest.mark.parametrize("suspected", [(3, 3), None])
async def test_an_earlier_leg_that_is_meant_by_a_doubt_is_read_again_and_no_other(suspected):
    async with Bench(PLAN) as bench:
        await bench.start()
        bench.oracle.answer = found(make_pose(2), forecasts=(_forecast(2),))
        await bench.until("placement-1/pose-2/leg-3-1")
        bench.suspect.of_pose = (Suspicion("other_pair", (1, 1), suspected, 300.1, 300.2),)
        await bench.do()

        await bench.press(CommandName.ANSWER, answer="reconnected")

        assert bench.present == "placement-1/pose-2/leg-1-1"
        assert bench.now.outcomes["placement-1/pose-2/initialise"].kind == "measured"
        assert bench.now.outcomes["placement-1/pose-2/leg-1-2"].kind == "measured"


async def test_an_answer_that_is_none_is_refused():
    async with Bench(PLAN).at(LEG) as bench:
        bench.hands.connect("leg", (2, 3))
        await bench.clock.advance(2.0)

        with pytest.raises(NotNowError, match="right_pair"):
            await bench.press(CommandName.ANSWER, answer="maybe")


async def test_legs_that_were_exchanged_are_both_read_again():
    async with Bench(PLAN) as bench:
        await bench.start()
        forecast = found(make_pose(2), forecasts=(_forecast(2),))
        bench.oracle.answer = forecast
        await bench.until("placement-1/pose-2/leg-3-1")
        bench.suspect.of_pose = (Suspicion("exchanged", (1, 1), (2, 2), 300.1, 300.2),)
        await bench.do()
        assert bench.now.suspicion is not None

        await bench.press(CommandName.ANSWER, answer="reconnected")

        kinds = {
            name[-3:]: outcome.kind for name, outcome in bench.now.outcomes.items() if "pose-2/leg" in name
        }
        assert {pair for pair, kind in kinds.items() if kind == "open"} == {"1-1", "2-2", "3-1"}
        assert bench.present == "placement-1/pose-2/leg-1-1"


def _forecast(config):
    covariance = tuple(tuple(1e-3 * (i == j) for j in range(6)) for i in range(6))
    return PoseForecast(config, LEGS, (300.0,) * 6, covariance)


async def test_a_calibrator_that_is_far_from_where_it_was_is_doubted():
    async with Bench(PLAN).at("placement-1/pose-1/initialise") as bench:
        bench.hands.connect("leg", (1, 1))  # not the calibrator
        bench.suspect.blind = True

        await bench.clock.advance(2.0)

        assert bench.now.suspicion.suspicion.kind == "not_calibrator"
        assert bench.kept("placement-1/pose-1/initialise") == []
