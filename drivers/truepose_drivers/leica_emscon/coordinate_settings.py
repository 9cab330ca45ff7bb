"""What makes a coordinate what it is (units, frame, mode, what is measured): read back, also after changes.

Another program may change any of it at the tracker, between two measurements or during one. The tracker
announces changes; whoever asks it to be silent is found out by reading back after every measurement.
"""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field

from truepose_drivers.errors import DeviceRefusedError, NotInitialisedError
from truepose_drivers.leica_emscon.error_codes import CommandUnknownError
from truepose_drivers.leica_emscon.protocol import Command, Record, SystemStatusChange, settings

Ask = Callable[[Command], Awaitable[Record]]

UNITS = Record(
    len_unit_type=settings.LengthUnit.MILLIMETER,
    ang_unit_type=settings.AngleUnit.RADIAN,
    temp_unit_type=settings.TemperatureUnit.CELSIUS,
    press_unit_type=settings.PressureUnit.HECTOPASCAL,
    hum_unit_type=settings.HumidityUnit.RELATIVE,
)
RIGHT_HANDED = Record(coord_sys_type=settings.CoordinateSystemType.RHR)
# Points come in the tracker's own frame: the world frame is the session's business.
OWN_FRAME = Record(
    apply_transformation_params=False,
    apply_station_orientation_params=False,
    try_measurement_mode=False,
)

TELLING_CHANGES = frozenset({
    SystemStatusChange.UNITS_CHANGED,
    SystemStatusChange.COORDINATE_SYSTEM_TYPE_CHANGED,
    SystemStatusChange.SYSTEM_SETTINGS_CHANGED,
    SystemStatusChange.STATION_ORIENTATION_PARAMS_CHANGED,
    SystemStatusChange.TRANSFORMATION_PARAMS_CHANGED,
    SystemStatusChange.MEASUREMENT_MODE_CHANGED,
    SystemStatusChange.REFLECTOR_CHANGED,
    SystemStatusChange.COMPENSATION_CHANGED,
    SystemStatusChange.MEASUREMENTCAMERA_CHANGED,
    SystemStatusChange.PROBE_CHANGED,
    SystemStatusChange.TIP_CHANGED,
    SystemStatusChange.TCAM_TO_TRACKER_COMPENSATION_CHANGED,
    SystemStatusChange.PROBE_COMPENSATION_CHANGED,
    SystemStatusChange.TIP_TO_PROBE_COMPENSATION_CHANGED,
    SystemStatusChange.SERVER_STARTED,
})
"""After these a coordinate may mean something else; what the weather changes is the tracker's own doing."""


@dataclass(frozen=True, slots=True)
class Setting:
    """One of them: how to ask for it, which members must be as we set them, which must stay as found."""

    name: str
    getter: Command
    wanted: Record = field(default_factory=Record)
    kept: tuple[str, ...] = ()
    required: bool = False  # a server that does not know the question is not measured with


_EVERY_TIME = (
    Setting("units", Command.GET_UNITS, UNITS, required=True),
    Setting("type of coordinates", Command.GET_COORDINATE_SYSTEM_TYPE, RIGHT_HANDED),
    Setting("settings", Command.GET_SYSTEM_SETTINGS, OWN_FRAME, ("weather_monitor_status",)),
)
COMPENSATION = Setting("compensation", Command.GET_COMPENSATION, kept=("internal_compensation_id",))


def mode(wanted: settings.MeasMode) -> Setting:
    """Return the measurement mode as a setting."""
    return Setting("measurement mode", Command.GET_MEASUREMENT_MODE, Record(meas_mode=wanted))


class CoordinateSettings:
    """What was found set after initialising."""

    def __init__(self, ask: Ask) -> None:
        self._ask = ask
        self._after_changes: tuple[Setting, ...] = ()
        self._found: dict[Command, Record] = {}

    async def settle(self, after_changes: tuple[Setting, ...]) -> None:
        """Read everything back, `after_changes` later only after a change that the tracker announces.

        Raises DeviceRefusedError where the tracker did not take a setting over.
        """
        self._after_changes = after_changes
        self._found = {}
        for item in (*_EVERY_TIME, *after_changes):
            found = await self._read_back(item)
            if found is None:
                continue
            wrong = _off(found, item.wanted)
            if wrong is not None:
                raise DeviceRefusedError(
                    f"the tracker did not accept its {item.name} ({wrong}): close every other program that"
                    " is connected to it, then initialise"
                )
            self._found[item.getter] = found

    async def require(self, *, everything: bool) -> None:
        """Read back what may have changed; raises NotInitialisedError where something has."""
        for item in (*_EVERY_TIME, *self._after_changes) if everything else _EVERY_TIME:
            # What the server did not know when it was initialised it does not know now.
            before = self._found.get(item.getter)
            if before is None:
                continue
            found = await self._ask(item.getter)
            wrong = _off(found, item.wanted) or _off(found, Record({k: before[k] for k in item.kept}))
            if wrong is not None:
                raise NotInitialisedError(
                    f"another program changed the {item.name} of the tracker ({wrong}), so its readings have"
                    " a different meaning: close that program, then initialise the tracker"
                )

    async def _read_back(self, item: Setting) -> Record | None:
        try:
            return await self._ask(item.getter)
        except CommandUnknownError as error:
            if item.required:
                raise DeviceRefusedError(
                    f"the tracker does not report its {item.name}: without a unit, a number is not a length"
                ) from error
            return None


def _off(found: Record, wanted: Record) -> str | None:
    """Return the first member that is not as it should be, None where all are."""
    for name, value in wanted.items():
        if found.get(name) != value:
            return f"{name} is {_shown(found.get(name))}, not {_shown(value)}"
    return None


def _shown(value: object) -> str:
    return str(getattr(value, "name", value)).lower()
