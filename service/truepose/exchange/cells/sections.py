"""The sections of a cell file, one reader each."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from datetime import date
from typing import Any, Final, TypeVar

from truepose.domain.cell import (
    Artefact,
    BallbarKit,
    Bars,
    CellLimits,
    CertifiedLength,
    Conditions,
    Detail,
    DeviceEntry,
    PlantedEffect,
    SimulatedCell,
)
from truepose.domain.people import announced_as, fault_of_name, tidy_name
from truepose.domain.robot import FixedNest, JointRange, Robot
from truepose.exchange.cells.volumes import KEY as KEEP_OUT
from truepose.exchange.cells.volumes import read_by_name, read_keep_outs
from truepose.exchange.document import NUMBER, TEXT, VECTOR, Form, Key, Node, each, number, read_keys, whole
from truepose.exchange.robots.document import ranges_of
from truepose.messages.catalogue import english

T = TypeVar("T")


def _read_date(node: Node) -> str:
    if isinstance(node.value, date):  # TOML has dates of its own
        return node.value.isoformat()[: len("2027-01-31")]
    try:
        return date.fromisoformat(node.text()).isoformat()
    except ValueError:
        node.fail(f"{node.value!r} is not a date; write it as 2027-01-31")


_DEVICE: Final = [
    Key("name", "name", TEXT),
    Key("driver", "driver", TEXT),
    Key("serial_number", "serial_number", TEXT, absent=""),
    Key("certificate", "certificate", TEXT, absent=""),
    Key("certificate_expires", "certificate_expires", Form(_read_date), absent=""),
    Key("use", "use", TEXT, absent=""),
]
_EFFECT: Final = [
    Key("name", "name", TEXT),
    Key("subject", "subject", TEXT, absent=""),
    Key("amplitude", "amplitude", NUMBER),
    Key("from_s", "from_s", number(least=0.0), absent=0.0),
]
_ADDRESSES = ("host", "serial", "usb")
_QUARTER_DEG = 90.0
_OF_SIMULATED_CELLS: Final = {"cell_clock", "cell_hands"}
_LAST_PORT = 65535
_ROUNDING_RAD = 1e-9  # limits come from degrees


def refuse_unlisted(node: Node, known: Collection[str]) -> None:
    """Refuse a key that is not `known`: a mistyped limit must not be ignored in a file that moves a robot."""
    for entry in node.unlisted(known):
        entry.fail(f"unknown key; the keys here are {', '.join(sorted(known))}")


def _sealed(kind: type[T], keys: Sequence[Key], extra: Collection[str] = ()) -> Form:
    """Return the form of a section with these keys and no others; `extra` ones are read elsewhere."""
    known = {key.name for key in keys} | set(extra)

    def read(node: Node) -> T:
        refuse_unlisted(node, known)
        return kind(**read_keys(node, keys))

    return Form(read)


def _defaulted(default: object, forms: Mapping[str, Form]) -> list[Key]:
    """Return keys called as their fields, which keep what `default` says where they are absent."""
    return [Key(name, name, form, absent=getattr(default, name)) for name, form in forms.items()]


_LENGTH: Final = number(above=0.0)
_FASTEST_MM_S: Final = 2000.0  # robot files state no top speed of the tool: one bound for all of them
_CELSIUS: Final = number(least=-50.0)
_EXPANSION: Final = Key("expansion_per_k", "expansion_per_k", number(above=-1e-4), absent=None)
_PAPER: Final = _defaulted(
    Artefact(""),
    {"name": TEXT, "serial_number": TEXT, "certificate": TEXT, "certificate_expires": Form(_read_date)},
)
ARTEFACT: Final = _sealed(Artefact, _PAPER)
TOOL: Final = _sealed(Artefact, _PAPER, extra={"mass_kg", "cog_mm"})
CONDITIONS: Final = _sealed(
    Conditions,
    _defaulted(
        Conditions(), {"load": TEXT, "warm_up": TEXT, "notes": each(TEXT), "part_temperature_c": _CELSIUS}
    ),
)
_BARS: Final = _sealed(
    Bars,
    [
        *(Key(name, name, _LENGTH) for name in ("nominal_mm", "calibrator_mm", "calibrator_u_mm")),
        Key("bars_mm", "bars_mm", each(_LENGTH), absent=()),
        _EXPANSION,
    ],
)
_KIT_LENGTHS: Final = ("range_mm", "reading_u_mm", "uncertified_u_mm", "zero_u_mm", "setup_u_mm")
# What is not given is as in the thesis.
BALLBAR: Final = _sealed(
    BallbarKit,
    _defaulted(
        BallbarKit(),
        {
            **dict.fromkeys(_KIT_LENGTHS, _LENGTH),
            "base_points": whole(least=3, greatest=4),
            "tool_bars": _BARS,
            "base_bars": _BARS,
            "instrument": ARTEFACT,
            "calibrator": ARTEFACT,
        },
    ),
)
FIXED_NEST: Final = _sealed(
    FixedNest, [Key("centre_mm", "centre_mm", VECTOR), Key("u_mm", "standard_uncertainty_mm", _LENGTH)]
)


def certified_length(n_fixed_nests: int) -> Form:
    """Return the form of a distance between two fixed nests that is certified on its own."""

    def pair(node: Node) -> tuple[int, int]:
        first, second = (entry.whole(least=1, greatest=n_fixed_nests) for entry in node.items(2))
        if first == second:
            node.fail("a length must join two different nests")
        return first, second

    keys = [
        Key("fixed_nests", "fixed_nests", Form(pair)),
        Key("length_mm", "length_mm", _LENGTH),
        Key("u_mm", "standard_uncertainty_mm", _LENGTH),
        _EXPANSION,
    ]
    return _sealed(CertifiedLength, keys)


def read_tracker(node: Node | None, n_fixed_nests: int) -> dict[str, Any]:
    """Read where the tracker stands in the world, and where it saw the fixed nests, in its own frame."""
    keys = [
        Key("position_mm", "tracker_position_mm", VECTOR, absent=None),
        Key("fixed_nests_seen_mm", "fixed_nests_seen_mm", each(VECTOR, n_fixed_nests), absent=None),
    ]
    if node is None:
        return {}
    refuse_unlisted(node, [key.name for key in keys])
    return read_keys(node, keys)


def limits_of(robot: Robot) -> Form:
    """Return the form of the limits, which may be tighter than the robot's own."""
    default = CellLimits()
    within = Form(lambda node: _read_within(node, robot))
    turning = Form(lambda node: math.radians(node.number(above=0.0)))
    keys = [
        Key("joints_deg", "joints", within, absent=None),
        Key("calibration_deg", "calibration", within, absent=None),
        Key(KEEP_OUT, "keep_outs", Form(read_keep_outs), absent=default.keep_outs),
        *_defaulted(default, {"floor_z_mm": NUMBER, "reference_mm": _LENGTH, "model_shift_mm": _LENGTH}),
        Key("tool_speed_mm_s", "tool_speed_mm_s", Form(_read_tool_speed), default.tool_speed_mm_s),
        Key("seen_within_deg", "seen_within_rad", Form(read_cone), absent=None),
        Key("orientation_speed_deg_s", "orientation_speed_rad_s", turning, default.orientation_speed_rad_s),
    ]
    return _sealed(CellLimits, keys)


def _read_tool_speed(node: Node) -> float:
    speed_mm_s = node.number(above=0.0)
    if speed_mm_s > _FASTEST_MM_S:
        node.fail(f"{speed_mm_s:g} mm/s is too fast for measuring; the limit is {_FASTEST_MM_S:g} mm/s")
    return speed_mm_s


def read_cone(node: Node) -> float:
    """Read half the angle of a cone within which something is seen."""
    angle_deg = node.number(above=0.0)
    if angle_deg >= _QUARTER_DEG:
        node.fail(
            f"{angle_deg:g} deg is not a valid cone angle; a corner cube is visible within 30 deg, a flat "
            "artefact within 15"
        )
    return math.radians(angle_deg)


def _read_within(node: Node, robot: Robot) -> tuple[JointRange, ...]:
    """Read ranges of the joints, none of them wider than what the robot's own controller accepts."""
    ranges: tuple[JointRange, ...] = ranges_of(robot.n_joints).read(node)
    if robot.joint_limits is None:
        return ranges
    for joint, (given, own) in enumerate(zip(ranges, robot.joint_limits, strict=True), start=1):
        # Both come from degrees in files: the same limit must not be refused for its last bit.
        low, high = own.lower_rad - _ROUNDING_RAD, own.upper_rad + _ROUNDING_RAD
        if not low <= given.lower_rad <= given.upper_rad <= high:
            node.items()[joint - 1].fail(
                f"joint {joint} would go from {_degrees(given)}, but the limits of the {robot.name} are "
                f"{_degrees(own)}; stay within them"
            )
    return ranges


def _degrees(limits: JointRange) -> str:
    return f"{math.degrees(limits.lower_rad):.10g} to {math.degrees(limits.upper_rad):.10g} deg"


def read_people(node: Node) -> tuple[str, ...]:
    """Read who may confirm; names that can be read, each once."""
    people: list[str] = []
    for entry in node.items():
        name = tidy_name(entry.text())
        fault = fault_of_name(name)
        if fault is not None:
            entry.fail(f"this name {english(fault)}; use a readable name")
        if announced_as(name, people) is not None:
            entry.fail(f"{name} is listed twice; keep one")
        people.append(name)
    if not people:
        node.fail(
            "no operators are listed, so nobody could confirm a motion; list operators, or remove the key"
        )
    return tuple(people)


def read_devices(node: Node) -> tuple[DeviceEntry, ...]:
    """Read the devices; their names differ."""
    devices = read_by_name(node, _read_device, "devices")
    # When all are known: which of two devices is the odd one follows from both.
    _refuse_mixture(node, devices)
    return tuple(devices.values())


def _refuse_mixture(node: Node, devices: Mapping[str, DeviceEntry]) -> None:
    """Refuse a clock or a person of a simulated cell beside a device that cannot be of the same cell.

    By a simulated clock nobody could tell how old the statement of a real robot is.
    """
    simulated = [device for device in devices.values() if device.driver in _OF_SIMULATED_CELLS]
    if not simulated:
        return
    host = simulated[0].options.get("host")
    for entry, device in zip(node.items(), devices.values(), strict=True):
        if device.options.get("host") != host:
            entry.fail(
                f"device {device.name} is not at {host}, where {simulated[0].name} of a simulated cell is: "
                "simulated and real devices must not be mixed"
            )


def _read_device(node: Node) -> DeviceEntry:
    said = read_keys(node, _DEVICE)
    addresses = [key for key in _ADDRESSES if key in node.entries()]
    if len(addresses) > 1:
        node.fail(f"device {said['name']} has the addresses {' and '.join(addresses)}; keep one")
    port = node.optional("port")
    if port is not None:
        port.whole(least=1, greatest=_LAST_PORT)
    return DeviceEntry(**said, options=_further(node, _DEVICE, _option))


def _further(node: Node, keys: Sequence[Key], read: Callable[[Node], T]) -> dict[str, T]:
    """Read what else stands there, by key."""
    return {str(entry.path[-1]): read(entry) for entry in node.unlisted([key.name for key in keys])}


def _option(node: Node) -> str | int | float | bool:
    if not isinstance(node.value, str | int | float | bool):
        node.fail("an option of a driver must be a text, a number, true or false")
    return node.value


def read_simulated(root: Node) -> SimulatedCell | None:
    """Read which simulation stands in for a cell, and the changes planted in it."""
    node, effects = root.optional("simulated"), root.optional("effect")
    if node is None:
        if effects is not None:
            effects.fail("effects can be simulated only in a simulated cell; [simulated] is missing")
        return None
    refuse_unlisted(node, [key.name for key in _SIMULATED])
    planted = () if effects is None else tuple(_read_effect(entry) for entry in effects.items())
    return SimulatedCell(**read_keys(node, _SIMULATED), effects=planted)


def _read_pace(node: Node) -> int:
    pace = node.whole(least=0)
    if pace > 1:
        node.fail("the pace must be 1 (real time) or 0 (no waiting)")
    return pace


_SIMULATED: Final = [
    Key("scenario", "scenario", TEXT),
    Key("seed", "seed", whole(least=0), absent=0),
    Key("pace", "pace", Form(_read_pace), absent=None),
]


def _read_effect(node: Node) -> PlantedEffect:
    return PlantedEffect(**read_keys(node, _EFFECT), details=_further(node, _EFFECT, _detail))


def _detail(node: Node) -> Detail:
    """Read a detail of an effect; which ones there are, the simulated cell says."""
    if isinstance(node.value, str):
        return node.text()
    return node.numbers() if isinstance(node.value, list) else node.number()
