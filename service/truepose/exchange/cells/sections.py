"""The sections of a cell file, one reader each."""

import math
from collections.abc import Collection
from datetime import date

from truepose.domain.artefacts import Artefact, BallbarKit, Bars
from truepose.domain.cell import (
    CellLimits,
    CertifiedLength,
    Conditions,
    Detail,
    DeviceEntry,
    PlantedEffect,
    SimulatedCell,
    Vector,
)
from truepose.domain.people import announced_as, fault_of_name, tidy_name
from truepose.domain.robot import FixedNest, JointRange, Robot
from truepose.exchange.document import Node
from truepose.exchange.robots.document import read_ranges

_DEVICE_KEYS = frozenset({"name", "driver", "serial_number", "certificate"})
_EFFECT_KEYS = frozenset({"name", "subject", "amplitude", "from_s"})
_ADDRESSES = ("host", "serial", "usb")
_LAST_PORT = 65535
_ROUNDING_RAD = 1e-9  # limits come from degrees


def refuse_unlisted(node: Node, known: Collection[str]) -> None:
    """Refuse a key that is not `known`: a mistyped limit must not be ignored in a file that moves a robot."""
    for entry in node.unlisted(known):
        entry.fail(f"there is no such key; the keys here are {', '.join(sorted(known))}")


def optional_text(node: Node, name: str) -> str:
    """Return a text, empty where the key is absent."""
    entry = node.optional(name)
    return "" if entry is None else entry.text()


def read_artefact(node: Node | None, extra: Collection[str] = ()) -> Artefact | None:
    """Read what an artefact is and what certifies it; `extra` keys are read elsewhere."""
    if node is None:
        return None
    refuse_unlisted(node, {"name", "serial_number", "certificate", "certificate_expires", *extra})
    return Artefact(
        name=optional_text(node, "name"),
        serial_number=optional_text(node, "serial_number"),
        certificate=optional_text(node, "certificate"),
        certificate_expires=_optional_date(node, "certificate_expires"),
    )


def _optional_date(node: Node, name: str) -> str:
    entry = node.optional(name)
    if entry is None:
        return ""
    if isinstance(entry.value, date):  # TOML has dates of its own
        return entry.value.isoformat()[: len("2027-01-31")]
    try:
        return date.fromisoformat(entry.text()).isoformat()
    except ValueError:
        entry.fail(f"{entry.value!r} is no date; write it as 2027-01-31")


def read_ballbar(node: Node | None) -> BallbarKit | None:
    """Read the ballbar with its calibrator and fixtures; what is not given is as in the thesis."""
    if node is None:
        return None
    own = ("range_mm", "reading_u_mm", "uncertified_u_mm", "zero_u_mm", "setup_u_mm")
    refuse_unlisted(node, {*own, "base_points", "tool_bars", "base_bars", "instrument", "calibrator"})
    default = BallbarKit()
    numbers = {name: _positive(node, name) or getattr(default, name) for name in own}
    points = node.optional("base_points")
    return BallbarKit(
        tool_bars=_read_bars(node.optional("tool_bars")) or default.tool_bars,
        base_bars=_read_bars(node.optional("base_bars")) or default.base_bars,
        base_points=default.base_points if points is None else points.whole(least=3, greatest=4),
        instrument=read_artefact(node.optional("instrument")) or default.instrument,
        calibrator=read_artefact(node.optional("calibrator")) or default.calibrator,
        **numbers,
    )


def _read_bars(node: Node | None) -> Bars | None:
    if node is None:
        return None
    refuse_unlisted(node, {"nominal_mm", "calibrator_mm", "calibrator_u_mm", "bars_mm"})
    bars = node.optional("bars_mm")
    return Bars(
        nominal_mm=node.key("nominal_mm").number(above=0.0),
        calibrator_mm=node.key("calibrator_mm").number(above=0.0),
        calibrator_u_mm=node.key("calibrator_u_mm").number(above=0.0),
        bars_mm=() if bars is None else tuple(bar.number(above=0.0) for bar in bars.items()),
    )


def read_fixed_nests(node: Node | None) -> tuple[FixedNest, ...]:
    """Read nests on the table, certified in the world frame."""
    return () if node is None else tuple(_read_fixed_nest(entry) for entry in node.items())


def _read_fixed_nest(node: Node) -> FixedNest:
    refuse_unlisted(node, {"centre_mm", "u_mm"})
    return FixedNest(node.key("centre_mm").vector(), node.key("u_mm").number(above=0.0))


def read_lengths(node: Node | None, n_fixed_nests: int) -> tuple[CertifiedLength, ...]:
    """Read distances between fixed nests that are certified on their own."""
    return () if node is None else tuple(_read_length(entry, n_fixed_nests) for entry in node.items())


def _read_length(node: Node, n_fixed_nests: int) -> CertifiedLength:
    refuse_unlisted(node, {"fixed_nests", "length_mm", "u_mm"})
    pair = node.key("fixed_nests")
    first, second = (entry.whole(least=1, greatest=n_fixed_nests) for entry in pair.items(2))
    if first == second:
        pair.fail("a length joins two different nests")
    length, uncertainty = (node.key(name).number(above=0.0) for name in ("length_mm", "u_mm"))
    return CertifiedLength((first, second), length, uncertainty)


def read_tracker_position(node: Node | None) -> Vector | None:
    """Read where the tracker nominally stands in the world."""
    if node is None:
        return None
    refuse_unlisted(node, {"position_mm", "fixed_nests_seen_mm"})
    position = node.optional("position_mm")
    return None if position is None else position.vector()


def read_seen(node: Node | None, n_fixed_nests: int) -> tuple[Vector, ...] | None:
    """Read where the tracker saw the fixed nests when somebody aimed at them, in its own frame."""
    seen = None if node is None else node.optional("fixed_nests_seen_mm")
    return None if seen is None else tuple(entry.vector() for entry in seen.items(n_fixed_nests))


def read_limits(node: Node | None, robot: Robot) -> CellLimits:
    """Read the limits, which may be tighter than the robot's own; what is not given keeps its default."""
    if node is None:
        return CellLimits()
    positive = ("reference_mm", "tool_speed_mm_s", "orientation_speed_deg_s")
    refuse_unlisted(node, {"joints_deg", "calibration_deg", "floor_z_mm", *positive})
    default = CellLimits()
    floor = node.optional("floor_z_mm")
    reference, speed, turning = (_positive(node, name) for name in positive)
    return CellLimits(
        joints=_read_within(node.optional("joints_deg"), robot),
        calibration=_read_within(node.optional("calibration_deg"), robot),
        floor_z_mm=None if floor is None else floor.number(),
        reference_mm=reference or default.reference_mm,
        tool_speed_mm_s=speed or default.tool_speed_mm_s,
        orientation_speed_rad_s=math.radians(turning) if turning else default.orientation_speed_rad_s,
    )


def _read_within(node: Node | None, robot: Robot) -> tuple[JointRange, ...] | None:
    """Read ranges of the joints, none of them wider than what the robot's own controller accepts."""
    ranges = read_ranges(node, robot.n_joints)
    if node is None or ranges is None or robot.joint_limits is None:
        return ranges
    for number, (given, own) in enumerate(zip(ranges, robot.joint_limits, strict=True), start=1):
        low, high = own.lower_rad - _ROUNDING_RAD, own.upper_rad + _ROUNDING_RAD
        if not low <= given.lower_rad <= given.upper_rad <= high:
            node.items()[number - 1].fail(
                f"joint {number} would go from {_degrees(given)}, where the {robot.name} itself goes from "
                f"{_degrees(own)}; keep within that"
            )
    return ranges


def _degrees(limits: JointRange) -> str:
    return f"{math.degrees(limits.lower_rad):.10g} to {math.degrees(limits.upper_rad):.10g} deg"


def _positive(node: Node, name: str) -> float | None:
    entry = node.optional(name)
    return None if entry is None else entry.number(above=0.0)


def read_people(node: Node | None) -> tuple[str, ...]:
    """Read who may confirm; names that can be read, each once."""
    people: list[str] = []
    for entry in () if node is None else node.items():
        name = tidy_name(entry.text())
        fault = fault_of_name(name)
        if fault is not None:
            entry.fail(f"this name {fault}; a name is what a person can read")
        if announced_as(name, people) is not None:
            entry.fail(f"{name} is announced twice; keep one")
        people.append(name)
    if node is not None and not people:
        node.fail("nobody is announced, so nobody could confirm; name people, or leave the key out")
    return tuple(people)


def read_conditions(node: Node | None) -> Conditions:
    """Read what a report states in the owner's words."""
    if node is None:
        return Conditions()
    refuse_unlisted(node, {"load", "warm_up", "notes"})
    notes = node.optional("notes")
    return Conditions(
        load=optional_text(node, "load"),
        warm_up=optional_text(node, "warm_up"),
        notes=() if notes is None else tuple(note.text() for note in notes.items()),
    )


def read_devices(node: Node | None) -> tuple[DeviceEntry, ...]:
    """Read the devices; their names differ."""
    if node is None:
        return ()
    devices: dict[str, DeviceEntry] = {}
    for entry in node.items():
        device = _read_device(entry)
        if device.name in devices:
            entry.key("name").fail(f"two devices are called {device.name!r}; names must differ")
        devices[device.name] = device
    return tuple(devices.values())


def _read_device(node: Node) -> DeviceEntry:
    name, driver = node.key("name").text(), node.key("driver").text()
    addresses = [key for key in _ADDRESSES if key in node.entries()]
    if len(addresses) > 1:
        node.fail(f"device {name} has the addresses {' and '.join(addresses)}; keep one")
    port = node.optional("port")
    if port is not None:
        port.whole(least=1, greatest=_LAST_PORT)
    return DeviceEntry(
        name=name,
        driver=driver,
        options={str(entry.path[-1]): _option(entry) for entry in node.unlisted(_DEVICE_KEYS)},
        serial_number=optional_text(node, "serial_number"),
        certificate=optional_text(node, "certificate"),
    )


def _option(node: Node) -> str | int | float | bool:
    if not isinstance(node.value, str | int | float | bool):
        node.fail("an option of a driver is a text, a number, true or false")
    return node.value


def read_simulated(root: Node) -> SimulatedCell | None:
    """Read which simulation stands in for a cell, and the changes planted in it."""
    node, effects = root.optional("simulated"), root.optional("effect")
    if node is None:
        if effects is not None:
            effects.fail("changes can be planted in a simulated cell only; [simulated] is missing")
        return None
    refuse_unlisted(node, {"scenario", "seed", "pace"})
    seed, pace = node.optional("seed"), node.optional("pace")
    return SimulatedCell(
        scenario=node.key("scenario").text(),
        seed=0 if seed is None else seed.whole(least=0),
        effects=() if effects is None else tuple(_read_effect(entry) for entry in effects.items()),
        pace=None if pace is None else _read_pace(pace),
    )


def _read_pace(node: Node) -> int:
    pace = node.whole(least=0)
    if pace > 1:
        node.fail("the pace is 1, real time, or 0: waiting costs nothing")
    return pace


def _read_effect(node: Node) -> PlantedEffect:
    start = node.optional("from_s")
    return PlantedEffect(
        name=node.key("name").text(),
        subject=optional_text(node, "subject"),
        amplitude=node.key("amplitude").number(),
        from_s=0.0 if start is None else start.number(least=0.0),
        details={str(entry.path[-1]): _detail(entry) for entry in node.unlisted(_EFFECT_KEYS)},
    )


def _detail(node: Node) -> Detail:
    """Read a detail of an effect; which ones there are, the simulated cell says."""
    if isinstance(node.value, str):
        return node.text()
    return node.numbers() if isinstance(node.value, list) else node.number()
