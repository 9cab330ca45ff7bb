"""A bench: how to make one driver's device in memory, what its readings must be, and where benches are found.

The author of a driver writes one class. It lays a line to a device that it plays (`driver`, `answer`), knows
what the device truly shows (`move`, `is_right`), and says which cases the protocol cannot have (`absent`).
"""

import importlib
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.metadata import entry_points
from typing import Any, ClassVar, Final, Literal, TypeAlias, TypeVar

import numpy as np

from truepose_drivers.api import DriverPlugin
from truepose_drivers.contract.wire import Wiring
from truepose_drivers.errors import ConfigurationError
from truepose_drivers.transports.conversation import Reader

Kind: TypeAlias = Literal["unit", "frozen", "stale", "foreign", "nonsense"]
Message = TypeVar("Message")


class Bench(ABC):
    """One device and its driver."""

    plugin: ClassVar[DriverPlugin]
    absent: ClassVar[Mapping[str, str]] = {}  # case -> why the protocol cannot have it
    specials: ClassVar[Mapping[str, Kind]] = {}  # what else this device can do wrong, see `special`
    free_numbers: ClassVar[bool] = False  # of any number of digits, so that one lost or doubled is not seen
    measures_s: ClassVar[float] = 0.0  # how long one reading takes
    lost_within_s: ClassVar[float] = 2.0  # after which silence the driver says that the device is gone

    def __init__(self) -> None:
        self.serial = "1001"  # of the device, as it tells it; another one where it was exchanged
        self.fault: str | None = None  # one of `specials`, which the device has now

    @abstractmethod
    def driver(self, wiring: Wiring) -> Any:
        """Return the driver on lines of `wiring`, not connected."""

    async def prepare(self, device: Any) -> None:
        """Do after connecting what the service does: initialise what can be initialised."""
        if hasattr(device, "initialise"):
            await device.initialise()

    @abstractmethod
    def move(self, rng: np.random.Generator) -> None:
        """Let what the device measures be something else from now on."""

    @abstractmethod
    async def ask(self, device: Any) -> object:
        """Return what the service would keep of one reading; None for one that says that there is none."""

    @abstractmethod
    def is_right(self, value: Any) -> bool:
        """Whether `ask` returned what the device truly shows."""

    def special(self, name: str, wiring: Wiring, rng: np.random.Generator) -> None:
        """Let the device do one of `specials`; its answers look at `fault`, unless this is overridden."""
        self.fault = name

    def mend(self) -> None:
        """End what `special` began."""
        self.fault = None

    def decoded(self, data: bytes) -> Sequence[object]:
        """Return what the driver's codec makes of bytes, see `codec_fuzz`; raises DriverError."""
        raise NotImplementedError(f"{type(self).__name__} does not say how the codec reads")

    def watched(self, device: Any) -> Any:
        """Return the device as the service uses it, where it puts something more between."""
        return device


class BallbarBench(Bench):
    """A ballbar, or a length gauge on its own; `true_mm` is what it shows."""

    range_mm: ClassVar[float] = 1.0
    step_mm: ClassVar[float] = 1e-4  # of its display

    def __init__(self) -> None:
        super().__init__()
        self.true_mm = 0.0

    def move(self, rng: np.random.Generator) -> None:
        """Shift it by whole steps; sometimes to where round numbers are."""
        most = round(self.range_mm / self.step_mm)
        steps = int(rng.integers(-most + 1, most))
        self.true_mm = (steps if rng.integers(4) else steps // 1000 * 1000) * self.step_mm

    async def ask(self, device: Any) -> float | None:
        """Return the deviation of a good reading [mm]."""
        reading = await device.read()
        return float(reading.deviation_mm) if reading.signal == "good" else None

    def is_right(self, value: float) -> bool:
        """Whether it is what the gauge shows, half a step more or less."""
        return abs(value - self.true_mm) <= 0.5 * self.step_mm + 1e-9


class RobotBench(Bench):
    """A robot; `joints_deg` are where its joints truly are."""

    ranges_deg: ClassVar[tuple[tuple[float, float], ...]] = ((-170.0, 170.0),) * 6
    decimals: ClassVar[int] = 2
    tolerance_deg: ClassVar[float] = 1e-6

    def __init__(self) -> None:
        super().__init__()
        self.joints_deg: tuple[float, ...] = (0.0,) * len(self.ranges_deg)

    def move(self, rng: np.random.Generator) -> None:
        """Let the arm stand elsewhere."""
        angles = (rng.uniform(lower, upper) for lower, upper in self.ranges_deg)
        self.joints_deg = tuple(round(float(angle), self.decimals) for angle in angles)

    async def ask(self, device: Any) -> tuple[float, ...]:
        """Return the joints [deg]."""
        return tuple(map(math.degrees, (await device.read_joints()).joints_rad))

    def is_right(self, value: tuple[float, ...]) -> bool:
        """Whether these are the joints, within `tolerance_deg`."""
        return len(value) == len(self.joints_deg) and all(
            abs(stated - true) <= self.tolerance_deg
            for stated, true in zip(value, self.joints_deg, strict=True)
        )


class TrackerBench(Bench):
    """A tracker of points; `point_mm` is where its reflector truly is."""

    tolerance_mm: ClassVar[float] = 1e-3
    measures_s = 1.0

    def __init__(self) -> None:
        super().__init__()
        self.point_mm: tuple[float, float, float] = (3000.0, 0.0, 0.0)

    def move(self, rng: np.random.Generator) -> None:
        """Put the reflector elsewhere."""
        x, y, z = map(float, rng.uniform(500.0, 4000.0, 3))
        self.point_mm = (x, y, z)

    async def ask(self, device: Any) -> tuple[float, float, float]:
        """Return a measured point [mm]."""
        point_mm: tuple[float, float, float] = (
            await device.measure_point(duration_s=self.measures_s)
        ).point_mm
        return point_mm

    def is_right(self, value: tuple[float, float, float]) -> bool:
        """Whether the point is that of the reflector, within `tolerance_mm`."""
        return math.dist(value, self.point_mm) <= self.tolerance_mm


class PoseTrackerBench(Bench):
    """A tracker of poses; `position_mm` is where its artefact truly is."""

    tolerance_mm: ClassVar[float] = 1e-3
    measures_s = 0.05

    def __init__(self) -> None:
        super().__init__()
        self.position_mm: tuple[float, float, float] = (0.0, 0.0, -2000.0)

    def move(self, rng: np.random.Generator) -> None:
        """Put the artefact elsewhere."""
        x, y, z = map(float, rng.uniform((-500.0, -500.0, -2500.0), (500.0, 500.0, -1500.0)))
        self.position_mm = (x, y, z)

    async def ask(self, device: Any) -> tuple[float, float, float]:
        """Return the position of a measured pose [mm]."""
        position_mm: tuple[float, float, float] = (
            await device.measure_pose(duration_s=self.measures_s)
        ).position_mm
        return position_mm

    def is_right(self, value: tuple[float, float, float]) -> bool:
        """Whether the position is that of the artefact, within `tolerance_mm`."""
        return math.dist(value, self.position_mm) <= self.tolerance_mm


def messages(
    reader: Reader[Message], data: bytes, decode: Callable[[Message], object] = lambda message: message
) -> list[object]:
    """Return all messages that a codec's reader makes of bytes, each read by `decode`."""
    reader.receive_data(data)
    found = []
    while (message := reader.next_message()) is not None:
        found.append(decode(message))
    return found


NewBench: TypeAlias = Callable[[], Bench]


ENTRY_POINT_GROUP: Final = "truepose.driver_benches"


def find_benches(named: Sequence[str], drivers: Sequence[str] | None) -> dict[str, NewBench]:
    """Return benches by the name of their driver, with its kind where it drives several.

    Those of `named` go before installed ones. Raises ConfigurationError where one cannot be used, or a driver
    of `drivers` has none.
    """
    # A later one takes the place of an earlier one: whoever works on a driver names the bench beside it.
    of_kind = {(bench.plugin.name, bench.plugin.kind): bench for bench in (*_installed(), *_named(named))}
    benches = list(of_kind.values())
    found = {bench.plugin.name for bench in benches}
    missing = [driver for driver in drivers or () if driver not in found]
    if missing:
        raise ConfigurationError(
            f"there is no bench for {', '.join(missing)}: register one in the entry-point group"
            f" {ENTRY_POINT_GROUP}, or name it with --bench MODULE:NAME;"
            f" there are {', '.join(sorted(found)) or 'none'}"
        )
    wanted = [bench for bench in benches if drivers is None or bench.plugin.name in drivers]
    return {_title(bench, wanted): bench for bench in wanted}


def _title(bench: type[Bench], benches: Sequence[type[Bench]]) -> str:
    name = bench.plugin.name
    alone = sum(other.plugin.name == name for other in benches) == 1
    return name if alone else f"{name}_{bench.plugin.kind}"


def _installed() -> Iterable[type[Bench]]:
    for entry in entry_points(group=ENTRY_POINT_GROUP):
        yield _checked(entry.name, entry.load())


def _named(places: Sequence[str]) -> Iterable[type[Bench]]:
    for place in places:
        module, _, name = place.partition(":")
        try:
            thing = getattr(importlib.import_module(module), name)
        except (ImportError, AttributeError, ValueError) as error:
            raise ConfigurationError(
                f"--bench {place} cannot be found ({error}): give MODULE:NAME"
            ) from error
        for bench in thing if isinstance(thing, list | tuple) else [thing]:
            yield _checked(place, bench)


def _checked(place: str, thing: object) -> type[Bench]:
    if not isinstance(thing, type) or not issubclass(thing, Bench):
        raise ConfigurationError(
            f"{place} is {thing!r}, not a subclass of truepose_drivers.contract.bench.Bench"
        )
    return thing
