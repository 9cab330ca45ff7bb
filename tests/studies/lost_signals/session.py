"""One ballbar session in memory whose ballbar loses its signal, and a person who confirms whatever is asked.

The person attaches the ballbar when a length is asked for, whether or not it can be read, forgets to take it
off every other time, and presses CONFIRM all the same. Two things only are left of their care: a reason is
true when it is given, and nobody attaches the ballbar where nothing asks for a length.
"""

import asyncio
import contextlib
import random
from collections import Counter
from dataclasses import dataclass, field
from typing import Final

from tests.unit.service.sessions.ballbar.fakes import Bench
from tests.unit.service.sessions.ballbar.sessions import make_plan
from truepose.domain.ballbar import StepKind
from truepose.domain.session import SessionState
from truepose.sessions.ballbar.state import READINGS
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.engine.states import has_ended
from truepose.sessions.errors import ReasonMissingError, SessionError
from truepose_drivers.errors import ConnectionLostError, NoReplyError

_PLAN: Final = make_plan((1, 2), precalibrate_after=1, stable_s=0.1, settle_s=0.0)
_DEEDS: Final = 250  # of the person, at most
_CALM_S, _TROUBLED_S = 4.0, 1.5  # how long signals stay and are gone, on average
_NEEDS_IT_OFF: Final = frozenset({StepKind.DETACH, StepKind.MOVE})
_FORGETS, _OUT_OF_REACH, _READS_ANOTHER_PAIR = 0.5, 0.15, 0.15
_RESTARTS: Final = 0.02
_TROUBLES: Final = ("switched off", "cable out", "silent line", "frozen", "wrong flag", "other serial")


@dataclass(slots=True)
class Seen:
    """What an onlooker saw, who knows where the ballbar is."""

    motions: int = 0
    motions_attached: int = 0
    confirmed_attached: int = 0  # a person said that it is off while it was on
    refused: int = 0  # of these
    reasons: int = 0
    finished: int = 0
    troubles: Counter[str] = field(default_factory=Counter)

    def add(self, other: "Seen") -> None:
        """Add what was seen of another session."""
        for name in self.__dataclass_fields__:
            setattr(self, name, getattr(self, name) + getattr(other, name))


async def session(seed: int) -> Seen:
    """Go through one session."""
    rng, seen = random.Random(seed), Seen()
    async with Bench(_PLAN) as bench:

        def judge() -> None:
            seen.motions += 1
            seen.motions_attached += bench.hands.at is not None

        bench.robot.judge = judge
        signals = asyncio.create_task(_come_and_go(bench, rng, seen))
        await bench.start()
        person = _Person(bench, rng, seen)
        for _ in range(_DEEDS):
            if has_ended(bench.now.state):
                break
            await person.deed()
        signals.cancel()
        await asyncio.gather(signals, return_exceptions=True)
        seen.finished += bench.now.state is SessionState.FINISHED
    return seen


async def _come_and_go(bench: Bench, rng: random.Random, seen: Seen) -> None:
    """Take signals away at random moments and bring them back."""
    bar = bench.bar
    while True:
        await bench.clock.sleep(rng.expovariate(1.0 / _CALM_S))
        trouble = rng.choice(_TROUBLES)
        seen.troubles[trouble] += 1
        match trouble:
            case "switched off":
                bar.switched_on = False
            case "cable out" | "silent line":
                bar.lost = ConnectionLostError if trouble == "cable out" else NoReplyError
                bar.plugged = False
            case "frozen":
                bar.frozen = True
            case "wrong flag":
                bar.flagged = True
            case _:
                bar.serial = "B-9"
        await bench.clock.sleep(rng.expovariate(1.0 / _TROUBLED_S))
        bar.switched_on = bar.plugged = True
        bar.frozen = bar.flagged = False
        if trouble != "other serial" or rng.random() < 0.5:  # else it stays, and somebody has to accept it
            bar.serial = "B-7"


class _Person:
    def __init__(self, bench: Bench, rng: random.Random, seen: Seen) -> None:
        self._bench = bench
        self._rng = rng
        self._seen = seen

    async def deed(self) -> None:
        bench, step = self._bench, self._bench.now.step
        if self._rng.random() < _RESTARTS:
            self._seen.troubles["service restarted"] += 1
            await bench.restart()
        elif bench.now.state is SessionState.PAUSED:
            await self._press(CommandName.RESUME)
        elif bench.now.state is SessionState.AWAITING_CONFIRMATION:
            foreign = bench.now.ballbar.foreign
            await self._press(CommandName.CONFIRM, accepted_serial=foreign.serial if foreign else "")
        elif bench.now.suspicion is not None:
            await self._press(CommandName.ANSWER, answer="right_pair")
        elif step is not None and step.kind in READINGS:
            await self._read()
        elif CommandName.CONFIRM in bench.now.acts:
            await self._confirm(needs_it_off=step is not None and step.kind in _NEEDS_IT_OFF)
        await bench.clock.advance(self._rng.choice((0.0, 0.1, 0.5)))

    async def _read(self) -> None:
        bench, rng = self._bench, self._rng
        step_id = bench.present or ""
        if bench.hands.at is not None:
            self._take_off()
            await bench.clock.advance(0.1)
        bench.hands.do_as_asked(step_id)
        if rng.random() < _OUT_OF_REACH:
            bench.bar.out_of_range_mm = 1.05  # the magnets reach these two balls, the transducer does not
        await bench.clock.advance(rng.choice((0.3, 1.0, 2.0)))
        if bench.present == step_id and rng.random() < 0.7:
            await self._press(rng.choice((CommandName.STORE, CommandName.SKIP)), reason="it reads nothing")

    async def _confirm(self, *, needs_it_off: bool) -> None:
        if needs_it_off and self._rng.random() >= _FORGETS:
            self._take_off()
        attached = needs_it_off and self._bench.hands.at is not None
        self._seen.confirmed_attached += attached
        try:
            await self._bench.press(CommandName.CONFIRM)
        except ReasonMissingError:
            self._seen.refused += attached
            if self._rng.random() < 0.5:
                await self._say_where_it_lies()
        except SessionError:
            self._seen.refused += attached

    async def _say_where_it_lies(self) -> None:
        self._take_off()
        self._seen.reasons += 1
        await self._press(CommandName.CONFIRM, reason="it lies on the table, its battery is out")

    def _take_off(self) -> None:
        self._bench.hands.detach()
        self._bench.bar.out_of_range_mm = None

    async def _press(self, name: CommandName, **said: str) -> None:
        with contextlib.suppress(SessionError):
            await self._bench.press(name, **said)
