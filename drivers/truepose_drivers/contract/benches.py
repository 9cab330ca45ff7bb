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
    """Return benches by the name of their driver; those of `named` go before installed ones.

    Raises ConfigurationError where one cannot be used, or a driver of `drivers` has none.
    """
    found = {bench.plugin.name: bench for bench in (*_installed(), *_named(named))}
    wanted = list(found) if drivers is None else drivers
    missing = [driver for driver in wanted if driver not in found]
    if missing:
        raise ConfigurationError(
            f"there is no bench for {', '.join(missing)}: register one in the entry-point group"
            f" {ENTRY_POINT_GROUP}, or name it with --bench MODULE:NAME;"
            f" there are {', '.join(found) or 'none'}"
        )
    return {driver: found[driver] for driver in wanted}


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
