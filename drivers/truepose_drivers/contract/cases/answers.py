"""Answers in another shape, at another time or from somebody else; questions given up, and some that meet."""

import asyncio
import contextlib
from typing import Final

from truepose_drivers.contract import wire_faults
from truepose_drivers.contract.bench import Kind
from truepose_drivers.contract.case import READ, Trial, broken, case
from truepose_drivers.contract.wire_faults import Fault
from truepose_drivers.errors import DriverError

_READINGS: Final = 5
_DEEPEST: Final = 4  # questions into a conversation at which a fault strikes
_SEEDS: Final = 5


@case(remedy="let `move` change what the device shows, and `is_right` compare with it")
async def the_bench_knows_a_wrong_value(trial: Trial) -> None:
    """A reading of before is wrong once what the device shows has moved: else no case could fail."""
    await trial.reach()
    before = await trial.bench.ask(trial.device)
    for _ in range(_READINGS):
        trial.bench.move(trial.rng)
        if not trial.bench.is_right(before):
            return
    broken(f"the bench accepts {before} as right, wherever it moves")


@case(remedy="compare units, signs and order of the numbers with the manual and with golden bytes")
async def whole_answers_are_right(trial: Trial) -> None:
    """What the driver returns is what the device shows, in mm, rad and s, every time."""
    await _read_several(trial)


@case(remedy="collect bytes until a message is complete, as LineReader does; decode nothing before")
async def answers_in_single_bytes_are_right(trial: Trial) -> None:
    """An answer that arrives byte by byte is the same answer."""
    trial.wiring.piece_bytes = 1
    await _read_several(trial)


@case(
    times=_SEEDS,
    remedy="take a number only when its message is complete; wait for the rest as long as for an answer",
)
async def answers_that_stall_are_waited_for(trial: Trial) -> None:
    """An answer that stalls for 50 ms, be it inside a number, is waited for and read whole."""
    await trial.read()
    trial.spoil(wire_faults.split, later=int(trial.rng.integers(_DEEPEST)))
    trial.bench.move(trial.rng)
    await trial.read()


@case(
    times=_SEEDS,
    remedy="check whether more data follows the answer, and refuse it; Conversation.ask does",
)
async def repeated_and_merged_answers_are_no_reading(trial: Trial) -> None:
    """An answer that comes twice, or into which another one runs, is read right or refused."""
    for fault in (wire_faults.repeat, wire_faults.merge):
        await _spoilt(trial, fault)


@case(
    times=_SEEDS,
    remedy="drain unrequested data before asking, and close the link after silence; Conversation does both",
)
async def stale_answers_are_no_reading(trial: Trial) -> None:
    """What belongs to an earlier question, in whole or in part, is never taken for the answer to this one."""
    for fault in (wire_faults.late, wire_faults.half_late, wire_faults.replay):
        await _spoilt(trial, fault)
    await _specials(trial, "stale")


@case(
    times=_SEEDS,
    remedy="raise RemoteProtocolError for what the codec does not know, and close the link: Turns does",
)
async def garbage_closes_the_link(trial: Trial) -> None:
    """Noise in place of an answer is refused, and the link is closed behind it."""
    await trial.read()
    trial.bench.move(trial.rng)
    trial.spoil(_noise)
    if isinstance(await trial.take(), DriverError) and trial.connected:
        broken("the driver refused garbage and left its link open")
    trial.mend()
    await trial.recover()
    for fault in (wire_faults.garbage, wire_faults.huge, wire_faults.truncate, wire_faults.cut):
        await _spoilt(trial, fault)


@case(
    special="nonsense",
    remedy="refuse values that are impossible for this kind of device: not finite, out of range, another"
    " form or count",
)
async def impossible_values_are_no_reading(trial: Trial) -> None:
    """A well-formed answer that no device can mean is refused."""
    await _specials(trial, "nonsense")


@case(
    special="foreign",
    remedy="compare the number, handle or name in the answer with the request",
)
async def answers_to_others_are_no_reading(trial: Trial) -> None:
    """What the device says to another program, of another part or at the press of a key is no reading."""
    await _specials(trial, "foreign")


@case(
    special="unit",
    remedy="ask for the unit with every reading, or set it and read it back; refuse an unknown one",
)
async def another_unit_changes_no_reading(trial: Trial) -> None:
    """A unit that is changed at the device is converted or refused, never taken for millimetres."""
    await _specials(trial, "unit")


@case(
    special="frozen",
    remedy="compare the device's count or time stamp with the last one, and refuse one that does not advance",
)
async def a_frozen_device_gives_no_reading(trial: Trial) -> None:
    """A device that repeats its last reading is not taken for one that stands still."""
    await _specials(trial, "frozen")


@case(
    kinds=tuple(kind for kind in READ if kind not in ("clock", "hands")),
    remedy="stamp with the clock that `open` was given, after the answer has come",
)
async def readings_are_stamped_by_the_cells_clock(trial: Trial) -> None:
    """Time stamps never run back, and no reading is stamped after it was returned."""
    await trial.read()
    stamps = [await _stamp(trial) for _ in range(3)]
    if stamps != sorted(stamps):
        broken(f"time stamps run back: {stamps}")


async def _stamp(trial: Trial) -> float:
    kind = trial.bench.plugin.kind
    match kind:
        case "tracker":
            reading = await trial.device.measure_point(duration_s=trial.bench.measures_s)
        case "pose_tracker":
            reading = await trial.device.measure_pose(duration_s=trial.bench.measures_s)
        case "robot":
            reading = await trial.device.read_joints()
        case _:
            reading = await trial.device.read()
    return float(reading.time_s)


async def _read_several(trial: Trial) -> None:
    for _ in range(_READINGS):
        trial.bench.move(trial.rng)
        await trial.read()


async def _spoilt(trial: Trial, fault: Fault) -> None:
    """Spoil one answer, wherever in the conversation; take nothing wrong, then or later."""
    await trial.reach()
    trial.bench.move(trial.rng)
    await trial.take()
    trial.spoil(fault, later=int(trial.rng.integers(_DEEPEST)))
    trial.bench.move(trial.rng)
    await trial.take()
    trial.mend()
    await trial.recover()


async def _specials(trial: Trial, kind: Kind) -> None:
    """Have the device do all that its bench lists of a kind; take nothing wrong, then or later."""
    for name in (name for name, its_kind in trial.bench.specials.items() if its_kind == kind):
        await trial.reach()
        await trial.take()
        trial.bench.move(trial.rng)
        trial.bench.special(name, trial.wiring, trial.rng)
        await trial.take()
        await trial.take()
        trial.mend()
        await trial.recover()


def _noise(*_: object) -> list[bytes]:
    return [b"\xff\xfe nonsense \x00\r\n\x03" * 3]


_AT_ONCE: Final = 5
_LATEST_S: Final = 0.1  # at which a question is given up


@case(
    times=12,
    remedy="hold the conversation in Turns.turn(), which closes the link after an abandoned request",
)
async def a_question_given_up_leaves_nothing_behind(trial: Trial) -> None:
    """A reading that is cancelled in the middle leaves no answer for the next one to take."""
    await trial.read()
    trial.bench.move(trial.rng)
    trial.spoil(wire_faults.split)
    asking = asyncio.create_task(trial.bench.ask(trial.device))
    await asyncio.sleep(float(trial.rng.uniform(0.0, _LATEST_S)))
    asking.cancel()
    with contextlib.suppress(asyncio.CancelledError, DriverError):
        await asking
    trial.mend()
    await trial.recover()


@case(
    times=4,
    remedy="let exchanges wait for each other: Conversation.ask does, Turns.turn() where you need more",
)
async def questions_at_once_get_their_own_answers(trial: Trial) -> None:
    """Several tasks that ask at once each get a right reading, or an error, never each other's answer."""
    await trial.read()
    trial.bench.move(trial.rng)
    await asyncio.gather(*(trial.take() for _ in range(_AT_ONCE)))
    await trial.recover()
