"""Which drivers are installed, and opening one by the name a cell file gives it.

Drivers register in the entry-point group `truepose.drivers`, ours and third-party ones alike. One that
cannot be loaded, or is no driver, is kept with its reason: it must not take the others down, and whoever
asks for it learns why it is missing.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import get_args

from truepose_drivers.api import AnyGuarded, Clock, DeviceKind, DriverPlugin, Options
from truepose_drivers.errors import ConfigurationError, DriverError
from truepose_drivers.guard import fault_of, guarded
from truepose_drivers.monotonic_clock import MonotonicClock

ENTRY_POINT_GROUP = "truepose.drivers"


@dataclass(frozen=True, slots=True)
class DriverRegistry:
    """Drivers by configuration name; `broken` says why an installed one cannot be used."""

    plugins: Mapping[str, DriverPlugin]
    broken: Mapping[str, str]

    def names(self, kind: DeviceKind | None = None) -> tuple[str, ...]:
        """Return the names of usable drivers, of one kind or of all, sorted."""
        return tuple(
            sorted(name for name, plugin in self.plugins.items() if kind is None or kind in _uses(plugin))
        )

    def plugin(self, name: str) -> DriverPlugin:
        """Return a driver by name; raises ConfigurationError that lists the known ones."""
        if name in self.plugins:
            return self.plugins[name]
        if name in self.broken:
            raise ConfigurationError(f"driver {name!r} is installed but cannot be used: {self.broken[name]}")
        known = ", ".join(self.names()) or "none"
        raise ConfigurationError(f"there is no driver {name!r}; installed drivers: {known}")

    def kind(self, name: str, use: str = "") -> DeviceKind:
        """Return as what a driver's device is used; raises ConfigurationError where it cannot be that."""
        uses = _uses(self.plugin(name))
        found = next((kind for kind in uses if kind == (use or uses[0])), None)
        if found is None:
            raise ConfigurationError(f"driver {name} cannot be used as {use!r}, but as {' or '.join(uses)}")
        return found

    def open(self, name: str, options: Options, clock: Clock | None = None, *, use: str = "") -> AnyGuarded:
        """Build a driver behind its guard; connects nothing.

        Without `clock` it stamps with the computer's monotonic time; without `use` its device is used as
        what the driver says first. Raises ConfigurationError for an unknown driver or option, or a value
        that does not fit.
        """
        plugin = self.plugin(name)
        # A misspelt option that is passed over would leave its default in force, and with it another speed or
        # port.
        unknown = sorted(set(options) - set(plugin.options))
        if unknown:
            known = ", ".join(plugin.options) or "none"
            raise ConfigurationError(
                f"driver {name} has no option {', '.join(unknown)}; its options: {known}"
            )
        try:
            return guarded(name, self.kind(name, use), plugin.open(options, clock or MonotonicClock()))
        except ConfigurationError as error:
            # A cell file has several devices, and the driver's own sentence does not say which.
            raise ConfigurationError(f"driver {name}: {error}") from error
        except DriverError:
            raise
        except Exception as error:
            raise fault_of(name, "open", error) from error


def load_registry(entries: Iterable[EntryPoint] | None = None) -> DriverRegistry:
    """Load every driver of the entry-point group, or of `entries`; never raises for a single one."""
    plugins: dict[str, DriverPlugin] = {}
    broken: dict[str, str] = {}
    for entry in entry_points(group=ENTRY_POINT_GROUP) if entries is None else entries:
        # Neither is taken: which of two comes first depends on the order of the search path, and another
        # driver could move the arm after an unrelated installation.
        if entry.name in plugins or entry.name in broken:
            plugins.pop(entry.name, None)
            broken[entry.name] = "two installed packages register a driver of this name: remove one"
            continue
        try:
            plugins[entry.name] = _checked(entry.name, entry.load())
        except ConfigurationError as error:
            broken[entry.name] = str(error)
        # SystemExit: a package that is run on import, or checks its licence there, must not end the service.
        except (Exception, SystemExit) as error:  # whatever foreign code does while it is imported
            broken[entry.name] = f"loading {entry.value} failed with {type(error).__name__}: {error}"
    return DriverRegistry(plugins, broken)


def _uses(plugin: DriverPlugin) -> tuple[DeviceKind, ...]:
    return plugin.kind, *plugin.also


def _checked(name: str, candidate: object) -> DriverPlugin:
    if not isinstance(candidate, DriverPlugin):
        raise ConfigurationError(f"its entry point is a {type(candidate).__name__}, not a DriverPlugin")
    if candidate.name != name:
        raise ConfigurationError(f"it calls itself {candidate.name!r} but is registered as {name!r}")
    for kind in _uses(candidate):
        if kind not in get_args(DeviceKind):
            kinds = ", ".join(get_args(DeviceKind))
            raise ConfigurationError(f"its kind is {kind!r}; known kinds: {kinds}")
    if not isinstance(candidate.options, Mapping) or not all(
        isinstance(text, str) for item in candidate.options.items() for text in item
    ):
        raise ConfigurationError("its options are not a mapping from option names to descriptions")
    if not callable(candidate.open):
        raise ConfigurationError("its open cannot be called")
    return candidate
