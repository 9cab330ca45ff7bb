"""A ballbar or a robot that is exchanged under a session: nothing is stored, nothing moves unasked."""

import contextlib

import pytest

from tests.unit.service.sessions.ballbar.fakes import Bench
from tests.unit.service.sessions.ballbar.sessions import CUP, KIT, make_plan
from truepose.domain.ballbar import StepKind
from truepose.domain.ledger import EntryKind
from truepose.domain.session import IdentityTaken, SessionState
from truepose.messages.catalogue import english
from truepose.sessions.ballbar import step_ids
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.engine.ledger import Expected
from truepose.sessions.errors import NotNowError, ReasonMissingError
from truepose_drivers.errors import NoReplyError

A, B = "B-7", "B-9"
SIDE = "tool/side-1-2"


async def settled(bench):
    await bench.clock.advance(0.5)


def lengths(bench):
    return [entry.length for entry in bench.disk.entries if entry.kind is EntryKind.MEASURED]


def findings(bench):
    taken = [entry.identity for entry in bench.disk.entries if entry.identity is not None]
    return [(t.device, t.finding, t.serial, t.person) for t in taken]


async def accept(bench, serial=B):
    return await bench.press(CommandName.CONFIRM, accepted_serial=serial)


async def test_who_was_met_first_is_in_the_ledger():
    async with Bench(make_plan((1, 2))).at(SIDE) as bench:
        assert sorted(findings(bench)) == [("ballbar", "first", A, None), ("robot", "first", "120-1", None)]


async def test_a_ballbar_that_the_cell_file_does_not_name_is_shown_and_not_stored():
    async with Bench(make_plan((1, 2)), expected=Expected({"ballbar": "B-1"})).at("tool/initialise") as bench:
        bench.hands.connect("calibrator")
        await bench.clock.advance(5.0)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert "B-1" in english(bench.now.question)
        assert A in english(bench.now.question)
        assert bench.runner._readings.sample.deviation_mm is not None
        assert lengths(bench) == []


async def test_one_that_is_exchanged_behind_a_link_that_stays_up_stops_at_the_next_store():
    async with Bench(make_plan((1, 2))).at(SIDE) as bench:
        stored = len(lengths(bench))

        bench.bar.serial = B
        bench.hands.detach()
        await bench.clock.advance(0.2)
        bench.hands.do_as_asked(SIDE)
        await bench.clock.advance(5.0)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert len(lengths(bench)) == stored
        assert B in english(bench.now.question)


async def test_the_button_stores_nothing_of_another_one():
    async with Bench(make_plan((1, 2))).at(SIDE) as bench:
        await bench.clock.advance(0.1)  # asked at the step, and not again before a length is kept
        bench.hands.do_as_asked(SIDE)
        bench.bar.serial = B

        with pytest.raises(NotNowError, match="Nothing was stored"):
            await bench.press(CommandName.STORE)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert len(lengths(bench)) == 1


async def test_an_exchange_while_the_cable_was_out_is_questioned_when_it_is_back():
    async with Bench(make_plan((1, 2))).at(SIDE) as bench:
        await bench.replug(B)

        assert bench.now.ballbar.foreign.serial == B
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION


@contextlib.asynccontextmanager
async def foreign_at(step_id):
    """A session in which another ballbar answers at a step."""
    async with Bench(make_plan((1, 2))).at(step_id) as bench:
        bench.bar.serial = B
        bench.hands.do_as_asked(step_id)
        await bench.clock.advance(5.0)
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        yield bench


async def test_a_person_accepts_it_by_name_and_its_zero_is_read_anew():
    async with foreign_at(SIDE) as bench:
        await accept(bench)

        assert findings(bench)[-1] == ("ballbar", "accepted", B, "Eva")
        assert bench.now.state is SessionState.RUNNING
        assert bench.now.step.kind is StepKind.INITIALISE
        await bench.until("tool/side-2-3")
        zero, side = lengths(bench)[-2:]
        assert [zero.instrument_serial, side.instrument_serial] == [B, B]


async def test_it_has_no_certificate_and_counts_with_the_uncertainty_of_one_without():
    async with Bench(make_plan((1, 2))).at(SIDE) as bench:
        await bench.until("tool/side-2-3")
        certified = lengths(bench)[-1]
        bench.bar.serial = B
        bench.hands.do_as_asked("tool/side-2-3")
        await bench.clock.advance(5.0)
        await accept(bench)
        await bench.until("tool/side-1-3")
        other = lengths(bench)[-1]

        assert (certified.certificate, certified.certificate_expires) == ("C-1", "2027-03-01")
        assert (other.certificate, other.certificate_expires) == ("", "")
        u_mm = (KIT.uncertified_u_mm, KIT.zero_u_mm, KIT.tool_bars.calibrator_u_mm)
        assert other.standard_uncertainty_mm == pytest.approx(sum(u**2 for u in u_mm) ** 0.5)
        assert other.standard_uncertainty_mm > 3.0 * certified.standard_uncertainty_mm


async def test_a_confirmation_that_names_no_number_or_another_accepts_nothing():
    async with foreign_at(SIDE) as bench:
        with pytest.raises(NotNowError, match="accept B-9"):
            await bench.press(CommandName.CONFIRM)
        with pytest.raises(NotNowError, match="nothing was accepted"):
            await accept(bench, "B-8")

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert findings(bench)[-1][1] == "foreign"


async def test_nothing_is_accepted_that_nobody_asked_about():
    async with Bench(make_plan((1, 2))).at(SIDE) as bench:
        await bench.press(CommandName.STOP)

        with pytest.raises(NotNowError, match="nothing was accepted"):
            await accept(bench, A)


async def test_one_that_is_put_back_closes_the_question_and_its_zero_is_read_anew():
    async with foreign_at(SIDE) as bench:
        bench.bar.serial = A
        await settled(bench)

        assert bench.now.ballbar.foreign is None
        assert B not in english(bench.now.question)
        await bench.press(CommandName.CONFIRM)
        assert bench.now.step.kind is StepKind.INITIALISE
        await bench.until("tool/side-2-3")
        assert {taken.certificate for taken in lengths(bench)} == {"C-1"}
        assert [f[1] for f in findings(bench) if f[0] == "ballbar"] == ["first", "foreign", "same"]


async def test_two_that_are_swapped_and_swapped_back_are_questioned_both_times():
    async with foreign_at(SIDE) as bench:
        await accept(bench)
        await bench.until("tool/side-2-3")

        bench.bar.serial = A
        bench.hands.do_as_asked("tool/side-2-3")
        await bench.clock.advance(5.0)
        assert f"accept {A}" in english(bench.now.question)
        await accept(bench, A)
        await bench.until("tool/side-1-3")

        last = lengths(bench)[-1]
        assert (last.instrument_serial, last.certificate) == (A, "C-1")
        assert [f[1:] for f in findings(bench) if f[1] == "accepted"] == [
            ("accepted", B, "Eva"),
            ("accepted", A, "Eva"),
        ]


async def test_the_question_survives_a_restart_and_so_does_the_answer():
    async with foreign_at(SIDE) as bench:
        await bench.restart()
        await settled(bench)
        assert B in english(bench.now.question)
        with pytest.raises(NotNowError):
            await bench.press(CommandName.CONFIRM)
        await accept(bench)
        await bench.restart()
        await settled(bench)

        assert bench.now.ballbar.serial == B
        assert bench.now.ballbar.foreign is None
        await bench.press(CommandName.CONFIRM)
        await bench.until("tool/side-2-3")
        assert lengths(bench)[-1].instrument_serial == B


async def test_while_paused_it_is_noted_and_asked_about_when_the_session_goes_on():
    async with Bench(make_plan((1, 2))).at(SIDE) as bench:
        await bench.press(CommandName.PAUSE)
        await bench.replug(B)

        assert bench.now.state is SessionState.PAUSED
        assert B in english(bench.now.question)
        await bench.press(CommandName.RESUME)
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION


async def test_nothing_moves_while_another_one_is_in_question():
    async with Bench(make_plan((1, 2))).at(CUP) as bench:
        bench.hands.connect("calibrator")
        await bench.replug(B)

        with pytest.raises(NotNowError):
            await bench.press(CommandName.CONFIRM)

        assert bench.robot.moves == []


async def test_one_that_never_tells_its_number_is_never_questioned():
    bench = Bench(make_plan((1, 2)), expected=Expected({"ballbar": A}))
    bench.bar.serial = "unknown"
    async with bench.at("tool/side-2-3"):
        assert [f for f in findings(bench) if f[0] == "ballbar"] == []
        assert {(t.instrument_serial, t.certificate) for t in lengths(bench)} == {(A, "C-1")}


async def test_one_that_falls_silent_is_noted_and_measures_on_without_a_certificate():
    async with Bench(make_plan((1, 2))).at(SIDE) as bench:
        await bench.replug("unknown")
        await bench.until("tool/side-2-3")

        assert bench.now.state is SessionState.RUNNING
        assert findings(bench)[-1][:2] == ("ballbar", "silent")
        assert (lengths(bench)[-1].instrument_serial, lengths(bench)[-1].certificate) == ("", "")


async def test_the_number_of_a_cable_is_not_that_of_the_gauge_behind_it():
    cable = "70012345"
    bench = Bench(make_plan((1, 2)), expected=Expected({"ballbar": cable}), ballbar_device_serial=cable)
    bench.bar.serial = cable
    async with bench.at("tool/side-2-3"):
        assert {(t.instrument_serial, t.certificate) for t in lengths(bench)} == {(A, "C-1")}


async def test_a_ballbar_that_does_not_answer_who_it_is_stores_nothing():
    async with Bench(make_plan((1, 2))).at(SIDE) as bench:
        await bench.clock.advance(0.1)
        bench.hands.do_as_asked(SIDE)

        async def nobody():
            raise NoReplyError("it says nothing")

        bench.bar.identify = nobody
        with pytest.raises(NotNowError, match="Nothing was stored"):
            await bench.press(CommandName.STORE)

        assert len(lengths(bench)) == 1


async def test_another_robot_is_refused_however_often_somebody_confirms():
    async with Bench(make_plan((1, 2))).at(SIDE) as bench:
        await bench.press(CommandName.STOP)
        bench.robot.serial = "120-2"

        for _ in range(3):
            await bench.press(CommandName.CONFIRM)
            assert bench.now.state is SessionState.AWAITING_CONFIRMATION
            assert "120-2" in english(bench.now.question)
        bench.robot.serial = "120-1"
        await bench.press(CommandName.CONFIRM)

        assert bench.now.state is SessionState.RUNNING


async def test_a_robot_that_is_exchanged_without_a_lost_link_does_not_move():
    async with Bench(make_plan((1, 2))).at(CUP) as bench:
        bench.robot.serial = "120-2"

        await bench.press(CommandName.CONFIRM)
        await settled(bench)

        assert bench.robot.moves == []
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert "120-2" in english(bench.now.question)


async def test_every_length_of_a_session_with_two_ballbars_counts_from_a_zero_of_its_own():
    async with foreign_at(SIDE) as bench:
        await accept(bench)
        await bench.until("placement-1/place")

        number_of = {}
        for entry in bench.disk.entries:
            if entry.kind is EntryKind.MEASURED:
                kind = step_ids.kind_of(entry.step_id)
                if kind is StepKind.INITIALISE:
                    number_of[entry.length.initialisation] = entry.length.instrument_serial
                assert number_of[entry.length.initialisation] == entry.length.instrument_serial
        assert set(number_of.values()) == {A, B}


async def test_another_one_shows_nothing_of_where_the_one_before_is():
    async with Bench(make_plan((1, 2))).at("tool/detach") as bench:
        bench.bar.serial = B
        bench.hands.hold()  # B; the one before is between two balls
        with pytest.raises(NotNowError):  # it is asked who it is
            await bench.press(CommandName.CONFIRM)
        assert B in english(bench.now.question)
        await accept(bench)
        assert bench.present == "tool/detach"

        with pytest.raises(ReasonMissingError):
            await bench.press(CommandName.CONFIRM)
        await bench.press(CommandName.CONFIRM, reason="the one before is in its box")

        assert not bench.now.attached


async def test_another_robot_that_is_on_record_does_not_move():
    async with Bench(make_plan((1, 2))).at(CUP) as bench:
        bench.robot.serial = "120-2"
        found = IdentityTaken("robot", "foreign", "120-2", "120-1")
        await bench.runner._logbook.append(EntryKind.CONTROL, text="Another robot answers.", identity=found)

        await bench.press(CommandName.CONFIRM)
        await bench.clock.advance(2.0)

        assert bench.robot.moves == []
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert "120-2" in english(bench.now.question)
