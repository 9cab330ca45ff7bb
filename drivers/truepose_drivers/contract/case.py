"""What a case is, and running one against a bench."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from truepose_drivers.api import DeviceKind
from truepose_drivers.contract.bench import Bench, Kind
from truepose_drivers.contract.simulated_time import SimulatedTimeLoop
from truepose_drivers.contract.trial import ContractBrokenError, Trial, broken

Asked: TypeAlias = Callable[[Trial], Awaitable[None]]
Outcome: TypeAlias = Literal["kept", "absent"]
NewBench: TypeAlias = Callable[[], Bench]

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
    ask: Asked


_CASES: dict[str, Case] = {}


def case(
    *,
    remedy: str,
    kinds: tuple[DeviceKind, ...] = READ,
    special: Kind | None = None,
    times: int = 1,
) -> Callable[[Asked], Asked]:
    """Enter a function among the cases: its name is the case's, its docstring what is asked."""

    def entered(ask: Asked) -> Asked:
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
