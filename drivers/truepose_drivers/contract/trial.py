"""One driver on its bench while a case asks something of it."""

import asyncio
import contextlib
from typing import Any, Final, NoReturn

import numpy as np

from truepose_drivers.contract.bench import Bench
from truepose_drivers.contract.spoiling import Fault, Pieces, whole
from truepose_drivers.contract.wire import Wiring
from truepose_drivers.errors import DriverError, DriverFaultError, NotInitialisedError
from truepose_drivers.guard import guarded

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
        except DriverFaultError as error:
            broken(f"the driver raised what is no DriverError: {error}")
        except DriverError as error:
            return error
        except Exception as error:
            broken(f"the driver raised {error!r}, which is no DriverError of truepose_drivers.errors")
        if value is not None and not self.bench.is_right(value):
            broken(f"the driver took {value} for a reading, and the device shows something else")
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
            broken("the driver returned a reading without a value, and the device shows one")

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


def now_s() -> float:
    """Return the time of the event loop [s]."""
    return asyncio.get_running_loop().time()
