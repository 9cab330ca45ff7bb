"""What a case is, and running one against a driver on its bench.

Waiting takes no time here, since the far ends live in memory. A socket, a process or a thread keeps the time
of the wall, and would be found silent.
"""

import asyncio
import contextlib
import selectors
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Final, Literal, NoReturn, TypeAlias

import numpy as np

from truepose_drivers.api import DeviceKind
from truepose_drivers.contract.bench import Bench, Kind, NewBench
from truepose_drivers.contract.wire import Wiring
from truepose_drivers.contract.wire_faults import Fault, Pieces, whole
from truepose_drivers.errors import DriverError, DriverFaultError, NotInitialisedError
from truepose_drivers.guard import guarded


class _JumpingSelector(selectors.DefaultSelector):
    """Lets time pass instead of waiting."""

    def __init__(self) -> None:
        super().__init__()
        self.passed_s = 0.0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if timeout is None:
            raise RuntimeError("the test waits for what nothing will bring about")
        events = super().select(0)
        if not events:
            # Not real time with short time-outs: that takes minutes, and finds drivers slow on a busy
            # machine.
            self.passed_s += max(timeout, 0.0)
        return events


class SimulatedTimeLoop(asyncio.SelectorEventLoop):
    """Runs as fast as the machine allows, the same on a busy one as on an idle one."""

    def __init__(self) -> None:
        self._jumping = _JumpingSelector()
        super().__init__(self._jumping)

    def time(self) -> float:
        """Return the seconds that passed in it."""
        return self._jumping.passed_s


_PATIENCE_S: Final = 300.0  # no driver may wait as long for a reading
_SETTLED_WITHIN: Final = 2  # good exchanges after a bad one


class ContractBrokenError(AssertionError):
    """A driver does not do what a case asks."""


def broken(what: str) -> NoReturn:
    """Say what the driver did instead."""
    raise ContractBrokenError(what)


class Trial:
    """A driver, its device, and what the device truly shows."""

    def __init__(self, bench: Bench, *, seed: int = 0, behind_guard: bool = False) -> None:
        self.bench = bench
        self.wiring = Wiring()
        self.rng = np.random.default_rng(seed)
        device = bench.driver(self.wiring)
        if behind_guard:
            device = guarded(bench.plugin.name, bench.plugin.kind, device)
        self.device: Any = bench.watched(device)
        self._ready = False
        self._earlier = b"?"

    @property
    def connects(self) -> bool:
        """Whether the driver has a link that is opened and closed; clocks do that by themselves."""
        return self.bench.plugin.kind != "clock"

    @property
    def connected(self) -> bool:
        """Whether the driver says that its link is up."""
        return self.connects and bool(self.device.connected)

    async def reach(self) -> None:
        """Connect and prepare as the service does, where the link is not up or the device was not ready."""
        if not self.connects:
            return
        if not self.device.connected:
            await self.device.connect()
            self._ready = False
        if not self._ready:
            await self.bench.prepare(self.device)
            self._ready = True

    async def ask(self) -> object:
        """Reach the device and take one reading; one that must be initialised is, before the next."""
        await self.reach()
        try:
            return await self.bench.ask(self.device)
        except NotInitialisedError:
            self._ready = False
            raise

    async def take(self) -> object:
        """Return a right value, None, or the DriverError instead; anything else breaks the contract."""
        try:
            async with asyncio.timeout(_PATIENCE_S):
                value = await self.ask()
        except TimeoutError:
            broken(f"the driver still waited after {_PATIENCE_S:g} s")
        # Before DriverError, of which it is one: the guard says by it that a driver raised something foreign.
        except DriverFaultError as error:
            broken(f"the driver raised something other than a DriverError: {error}")
        except DriverError as error:
            return error
        except Exception as error:
            broken(f"the driver raised {error!r}, which is not a DriverError of truepose_drivers.errors")
        if value is not None and not self.bench.is_right(value):
            broken(f"the driver returned {value} as a reading, but the device shows something else")
        return value

    async def refuse(self) -> DriverError:
        """Return the error of a driver that takes nothing for a reading now."""
        taken = await self.take()
        if not isinstance(taken, DriverError):
            broken(f"the driver returned {taken}, where nothing could be read")
        return taken

    async def read(self) -> None:
        """See that a reading is taken, and is right."""
        taken = await self.take()
        if isinstance(taken, DriverError):
            broken(f"the driver refused a good reading: {taken!r}")
        if taken is None:
            broken("the driver returned a reading without a value, but the device shows one")

    async def recover(self) -> None:
        """See that the driver is in step again within two good exchanges."""
        for _ in range(_SETTLED_WITHIN):
            self.bench.move(self.rng)
            taken = await self.take()
            if taken is not None and not isinstance(taken, DriverError):
                return
        broken(f"the driver is not in step after {_SETTLED_WITHIN} good exchanges: {taken!r}")

    async def close(self) -> None:
        """Close the driver; one that cannot even do that has broken another case."""
        with contextlib.suppress(Exception):
            await self.device.close()

    def spoil(self, fault: Fault, *, later: int = 0) -> None:
        """Have a fault befall the next answer, or one that is `later` in the conversation."""

        def spoiled(said: Pieces) -> Pieces:
            nonlocal later
            if later > 0:
                later -= 1
                self.wiring.spoil = spoiled
                return said
            earlier, self._earlier = self._earlier, whole(said)
            return fault(self.rng, said, earlier)

        self.wiring.spoil = spoiled

    def mend(self) -> None:
        """End every fault of the lines and of the device."""
        self.wiring.spoil = None
        self.wiring.deaf = self.wiring.unreachable = False
        self.bench.mend()


CaseFunction: TypeAlias = Callable[[Trial], Awaitable[None]]
Outcome: TypeAlias = Literal["kept", "absent"]

LINKED: Final[tuple[DeviceKind, ...]] = (
    "tracker",
    "pose_tracker",
    "robot",
    "ballbar",
    "linear_gauge",
    "hands",
)
READ: Final[tuple[DeviceKind, ...]] = (*LINKED, "clock")


@dataclass(frozen=True, slots=True)
class Case:
    """One thing that is asked of a driver."""

    name: str
    asks: str  # one sentence
    remedy: str  # what the driver's author does where it fails
    kinds: tuple[DeviceKind, ...]  # of devices that are asked
    special: Kind | None  # what the bench must be able to do
    times: int  # with as many seeds
    ask: CaseFunction


_CASES: dict[str, Case] = {}


def case(
    *,
    remedy: str,
    kinds: tuple[DeviceKind, ...] = READ,
    special: Kind | None = None,
    times: int = 1,
) -> Callable[[CaseFunction], CaseFunction]:
    """Enter a function among the cases: its name is the case's, its docstring what is asked."""

    def entered(ask: CaseFunction) -> CaseFunction:
        name = ask.__name__
        asks = " ".join((ask.__doc__ or "").split())
        _CASES[name] = Case(name, asks, remedy, kinds, special, times, ask)
        return ask

    return entered


def entered_cases() -> tuple[Case, ...]:
    """Return the cases that were entered so far, in their order."""
    return tuple(_CASES.values())


def reason_absent(one: Case, bench: Bench) -> str | None:
    """Return why a case is not asked of a driver, None where it is."""
    if one.name in bench.absent:
        return bench.absent[one.name]
    if bench.plugin.kind not in one.kinds:
        return f"not asked of a {bench.plugin.kind.replace('_', ' ')}"
    return None


def run(one: Case, new_bench: NewBench) -> Outcome:
    """Ask a case of a driver; raises ContractBrokenError that says what it did and what its author does."""
    bench = new_bench()
    if reason_absent(one, bench) is not None:
        return "absent"
    try:
        _require_special(one, bench)
        for seed in range(one.times):
            with asyncio.Runner(loop_factory=SimulatedTimeLoop) as runner:
                runner.run(_asked(one, new_bench(), seed))
    except ContractBrokenError as error:
        raise ContractBrokenError(
            f"{bench.plugin.name}: {error}\n  asked: {one.asks}\n  to do: {one.remedy}"
        ) from error
    return "kept"


async def _asked(one: Case, bench: Bench, seed: int) -> None:
    trial = Trial(bench, seed=seed)
    try:
        await one.ask(trial)
    finally:
        await trial.close()


def _require_special(one: Case, bench: Bench) -> None:
    if one.special is not None and one.special not in bench.specials.values():
        broken(
            f"the bench has no special of the kind {one.special!r}: give it one, or say in `absent` why the"
            " protocol cannot have it"
        )


def unknown_absences(bench: Bench, cases: tuple[Case, ...]) -> list[str]:
    """Return what a bench declares absent and is no case, or has no reason."""
    names = {one.name for one in cases}
    return [name for name, reason in bench.absent.items() if name not in names or not reason.strip()]
