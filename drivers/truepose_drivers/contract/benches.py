"""Finding the benches of drivers: those that installed packages bring, and those that are named."""

import importlib
from collections.abc import Iterable, Sequence
from importlib.metadata import entry_points
from typing import Final

from truepose_drivers.contract.bench import Bench
from truepose_drivers.contract.case import NewBench
from truepose_drivers.errors import ConfigurationError

ENTRY_POINT_GROUP: Final = "truepose.driver_benches"


def find_benches(named: Sequence[str], drivers: Sequence[str] | None) -> dict[str, NewBench]:
    """Return benches by the name of their driver, with its kind where it drives several.

    Those of `named` go before installed ones. Raises ConfigurationError where one cannot be used, or a driver
    of `drivers` has none.
    """
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
            f"{place} is {thing!r}, and no subclass of truepose_drivers.contract.bench.Bench"
        )
    return thing
