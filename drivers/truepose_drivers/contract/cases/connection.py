"""Connecting, saying who is there, losing the link and coming back."""

import asyncio
from typing import Final

from truepose_drivers.contract.case import LINKED, ContractBrokenError, Trial, broken, case
from truepose_drivers.contract.wire import HangUp, Piece, Silence
from truepose_drivers.errors import ConnectFailedError, DriverError, LinkError
from truepose_drivers.transports.link import now_s

_BACK_WITHIN_S: Final = 5.0
_RETRY_S: Final = 0.25  # between two attempts to connect
_FURTHER_SERIAL: Final = "2002"


@case(
    kinds=LINKED,
    remedy="open nothing in the driver's constructor; the service connects when the cell is ready",
)
async def nothing_is_opened_before_connect(trial: Trial) -> None:
    """A driver that was only made has no connection, has sent nothing, and can be closed."""
    if trial.device.connected or trial.wiring.sent:
        broken("the driver is connected, or has sent something, before anybody called connect")
    await trial.device.close()
    await trial.device.close()


@case(
    kinds=LINKED,
    remedy="let the link raise its ConnectionLostError, which says 'connect first'",
)
async def nothing_is_read_without_a_connection(trial: Trial) -> None:
    """Reading and identifying before connect are refused with a sentence that says to connect."""
    for question in (trial.bench.ask(trial.device), trial.device.identify()):
        try:
            answer = await question
        except DriverError as error:
            if "connect" not in str(error) and "initialised" not in str(error):
                broken(f"the sentence does not say to connect: {error}")
        else:
            broken(f"the driver returned {answer} without a connection")


@case(
    kinds=LINKED,
    remedy="raise ConnectFailedError with address and remedy, as TcpLink does",
)
async def nobody_at_the_address_is_told(trial: Trial) -> None:
    """Where nobody answers, connect raises ConnectFailedError that says what to check."""
    trial.wiring.unreachable = True
    error = await _require_failing(trial, "nobody is there")
    if "check" not in str(error):
        broken(f"the sentence does not say what to check: {error}")


@case(
    kinds=LINKED,
    remedy="end connect by asking who is there; close the link if no such device answers",
)
async def connect_asks_who_is_there(trial: Trial) -> None:
    """An open port behind which nobody speaks the protocol is no connection."""
    trial.wiring.deaf = True
    began_s = now_s()
    await _require_failing(trial, "the device has not answered")
    if now_s() - began_s > _BACK_WITHIN_S:
        broken(f"connect noticed the silence after {now_s() - began_s:.1f} s only")


@case(
    kinds=LINKED,
    remedy="ask who is there within `introduction`, which makes the end of the connection a failed one",
)
async def a_device_that_hangs_up_at_once_was_not_connected(trial: Trial) -> None:
    """A device that ends the connection before it has said who it is makes connect fail."""

    def hangs_up(_: object) -> list[Piece]:
        trial.wiring.spoil = hangs_up
        return [HangUp()]

    trial.wiring.spoil = hangs_up
    await _require_failing(trial, "the device has closed the connection")


@case(
    kinds=LINKED,
    times=3,
    remedy="decode who answers in connect, and close the link where it is not this protocol",
)
async def connect_refuses_another_protocol(trial: Trial) -> None:
    """A server of another kind at the address is told in connect, and its link closed."""
    greetings = (
        b"HTTP/1.1 400 Bad Request\r\n\r\n",
        b"SSH-2.0-OpenSSH_9.6\r\n",
        b"\x15\x03\x01\x00\x02\x02\x50",
    )

    def foreign(_: object) -> list[Piece]:
        trial.wiring.spoil = foreign
        return [greetings[int(trial.rng.integers(3))], Silence()]

    trial.wiring.spoil = foreign
    try:
        await trial.device.connect()
    except DriverError:
        _require_closed(trial)
    else:
        broken("connect took another server for the device")


@case(
    kinds=LINKED,
    remedy="ask the device in identify; write 'unknown' where the protocol does not tell",
)
async def it_says_who_it_is(trial: Trial) -> None:
    """Identify tells manufacturer, model, serial number and firmware, none of them empty."""
    await trial.device.connect()
    identity = await trial.device.identify()
    words = (identity.manufacturer, identity.model, identity.serial, identity.firmware)
    if not all(isinstance(word, str) and word.strip() for word in words):
        broken(f"identify returned {identity}")
    if not trial.device.connected:
        broken("the link is closed after identify")


@case(
    kinds=LINKED,
    remedy="ask for the serial number at every identify; keep none from one connection to the next",
)
async def another_serial_number_is_told(trial: Trial) -> None:
    """After a reconnection, identify tells the serial number of the device that answers now."""
    await trial.device.connect()
    first = (await trial.device.identify()).serial
    if first != trial.bench.serial:
        broken(f"identify reports serial number {first}, and the device says {trial.bench.serial}")
    trial.bench.serial = _FURTHER_SERIAL
    trial.wiring.hang_up()
    await trial.device.close()
    await trial.device.connect()
    again = (await trial.device.identify()).serial
    if again != _FURTHER_SERIAL:
        broken(f"another device answers, {_FURTHER_SERIAL}, but identify reports {again}")


@case(
    kinds=LINKED,
    remedy="let connect close the old link and forget its state",
)
async def connecting_again_begins_afresh(trial: Trial) -> None:
    """Connect may be called again at any time, and readings go on."""
    for _ in range(3):
        await trial.device.connect()
        await trial.bench.prepare(trial.device)
        trial.bench.move(trial.rng)
        await trial.read()


@case(
    kinds=LINKED,
    remedy="pass ConnectionLostError of the link on, and let `connected` return the state of the link",
)
async def a_device_that_hangs_up_is_lost_and_comes_back(trial: Trial) -> None:
    """A connection that the device ends is a LinkError, `connected` is false, and connect brings it back."""
    await trial.read()
    trial.wiring.hang_up()
    error = await trial.refuse()
    if not isinstance(error, LinkError):
        broken(f"the driver raised {error!r}, which is not a LinkError")
    _require_closed(trial)
    await trial.recover()


@case(
    remedy="give every question a time-out below 2 s, raise NoReplyError behind it and close the link",
)
async def silence_is_told_within_two_seconds(trial: Trial) -> None:
    """A line that is half open, on which nothing comes any more, is a LinkError within 2 s, and closed."""
    await trial.read()
    trial.wiring.deaf = True
    began_s = now_s()
    error = await trial.refuse()
    allowed_s = trial.bench.measures_s + trial.bench.lost_within_s
    if now_s() - began_s > allowed_s:
        broken(f"the silence was reported after {now_s() - began_s:.2f} s, and {allowed_s:g} s are allowed")
    if not isinstance(error, LinkError):
        broken(f"the driver raised {error!r}, which is not a LinkError")
    _require_closed(trial)


@case(
    times=3,
    remedy="keep nothing of the old connection in connect; do not wait longer for a device than 5 s",
)
async def it_is_back_within_five_seconds(trial: Trial) -> None:
    """A device that is back is read again within 5 s, and nothing that it said before is taken."""
    await trial.read()
    trial.wiring.deaf = trial.wiring.unreachable = True
    trial.bench.move(trial.rng)
    await trial.refuse()
    for _ in range(int(trial.rng.integers(3))):
        await trial.refuse()
        await asyncio.sleep(_RETRY_S)
    trial.mend()
    back_s = now_s()
    while isinstance(await trial.take(), DriverError):
        await asyncio.sleep(_RETRY_S)
        if now_s() - back_s > _BACK_WITHIN_S + trial.bench.measures_s:
            broken(f"the device is back, and was not read for {now_s() - back_s:.1f} s")


async def _require_failing(trial: Trial, why: str) -> ConnectFailedError:
    """Return the error of a connect that must fail, and has left nothing open."""
    try:
        await trial.device.connect()
    except ConnectFailedError as error:
        _require_closed(trial)
        return error
    except DriverError as other:
        did = f"raised {other!r}, which is not a ConnectFailedError"
    else:
        did = "returned"
    raise ContractBrokenError(f"{why}, and connect {did}")


def _require_closed(trial: Trial) -> None:
    if trial.connected:
        broken("the driver reports its link as up, but it must be closed")
