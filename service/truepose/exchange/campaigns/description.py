"""`campaign.json`: everything of a campaign but its tables.

Five optional keys are this program's own. `simulated` is true where no robot and no instrument took part;
where it is absent nobody said so. `measured_on` is the day of the readings, as 2026-03-03;
`robot_serial_number` and `instrument_serial_number` say which robot was measured by what. And
`world_registration` is an object with `covariance_mm_rad`, the 6x6 covariance (rows and columns: translation
x y z in mm, rotation vector x y z in rad) of a small motion about the world origin by which the readings may
sit wrong in the world.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign
from truepose.domain.robot import FixedNest, Nest, Robot, WorldRegistration
from truepose.exchange.document import (
    TEXT,
    TRUTH,
    VECTOR,
    Form,
    Key,
    Node,
    degrees,
    each,
    number,
    or_null,
    read_keys,
    written_keys,
)
from truepose.exchange.errors import MissingEntryError, NewerVersionError, WrongUnitError
from truepose.exchange.json_text import Json
from truepose.exchange.robots.document import (
    GRAVITY,
    PLACEMENT,
    arm_keys,
    covariance_document,
    joints_document,
    read_covariance,
    read_direction,
    read_joints,
)
from truepose.messages.message import Message, message

_NOTED: Final = "SIMULATED:"


def read_simulated(root: Node, notes: Iterable[str]) -> bool | None:
    """Return what the description says; older archives of this program say it in a note. None: nothing."""
    said = root.optional("simulated")
    if said is not None:
        return said.truth()
    return True if any(note.startswith(_NOTED) for note in notes) else None


def read_day(node: Node) -> date:
    """Return the day here."""
    text = node.text()
    try:
        day = date.fromisoformat(text)
    except ValueError:
        node.fail(f"{text!r} is not a date; write it as YYYY-MM-DD, such as 2026-03-03")
    if day.isoformat() != text:  # of other ways to write a day, such as weeks
        node.fail(f"{text!r} is not a date such as 2026-03-03")
    return day


FORMAT = 1
ROLES = (
    "calibration",
    "validation",
    "reference",
    "legs",
    "validation_legs",
    "setup",
    "fixture",
    "cups",
    "contacts",
    "validation_contacts",
    "targets",
    "target_distances",
)
_READING_ROLES = (
    "calibration", "validation", "legs", "validation_legs", "contacts", "validation_contacts",
)  # fmt: skip
_KINDS = ("tracker", "ballbar", "contacts")
_IN_ORDER = (
    "format", "kind", "robot", "dhm_nominal", "base_in_world_nominal", "tool_nests_mm", "tool_nest_u_mm",
    "masses", "gravity_m_s2_world", "robot_repeatability_mm", "u_includes_repeatability", "gear_ratio",
    "typical_compliance_rad_per_Nmm", "tool_nest_axis", "tool_rotation_u_deg", "tracker_position_world_mm",
    "fixed_nests_certified_mm", "fixed_nest_u_mm", "ballbar_nominal_mm", "ballbar_range_mm", "setup_u_mm",
    "simulated", "measured_on", "robot_serial_number", "instrument_serial_number", "world_registration",
    "notes", "files",
)  # fmt: skip
KEYS = frozenset(_IN_ORDER)
_NULL_IF_UNKNOWN = frozenset({"base_in_world_nominal", "tool_nest_u_mm"})  # the others are left out
_JOINT_KEYS = frozenset({"joint", "alpha_deg", "a_mm", "theta_offset_deg", "d_mm", "sign", "beta_deg"})


@dataclass(frozen=True, slots=True)
class Description:
    """A campaign without its tables, and the file name of each of them by role."""

    campaign: Campaign
    files: dict[str, str]
    files_node: Node


def read_description(root: Node) -> Description:
    """Read `campaign.json`; raises an InputFileError that names key and line."""
    _check_format(root)
    _check_kind(root.optional("kind"))
    robot = described_robot(root)
    files = _read_files(root.key("files"))
    if "setup" in files and root.optional("setup_u_mm") is None:
        root.fail("key setup_u_mm is missing; it is required where files names a setup", MissingEntryError)
    _refuse_other_gravity(root)
    said = read_keys(root, _CAMPAIGN)
    campaign = Campaign(
        **said,
        robot=robot,
        nests=_read_nests(root),
        fixed_nests=_read_fixed_nests(root),
        simulated=read_simulated(root, said["notes"]),
        ignored=tuple(_ignored(root)),
    )
    return Description(campaign, files, root.key("files"))


def _check_format(root: Node) -> None:
    version = root.key("format")
    # Before anything else: what a later format means is not known, and its first unknown key would be blamed.
    number = version.whole()
    if number > FORMAT:
        version.fail(
            f"the campaign has format {number}; this program reads format {FORMAT}", NewerVersionError
        )
    if number < FORMAT:
        version.fail(f"format {number} does not exist; it must be {FORMAT}")


def _check_kind(kind: Node | None) -> None:
    """Refuse a kind that there is not; what is measured, the tables say."""
    if kind is not None and kind.text() not in _KINDS:
        kind.fail(f"{kind.text()!r} is not a kind of campaign; it must be one of {', '.join(_KINDS)}")


def described_robot(root: Node) -> Robot:
    """Return the robot that a description describes; raises InputFileError."""
    joints = read_joints(root.key("dhm_nominal"))
    return Robot(root.key("robot").text(), joints, **read_keys(root, arm_keys(len(joints))))


def _refuse_other_gravity(root: Node) -> None:
    wanted = "gravity_m_s2_world"
    others = [name for name in root.entries() if name.startswith("gravity") and name != wanted]
    if wanted not in root.entries() and others:
        root.child(others[0], None).fail(
            f"key {others[0]} has another frame or unit; {wanted} in m/s2 in the world frame is required",
            WrongUnitError,
        )


MOST_NESTS: Final = 999  # more than anybody has


def unknown_nests(named: Iterable[FloatArray]) -> list[None]:
    """Return as many nests of unknown place as columns of readings name.

    A number that no nest has counts for none: whoever reads the table refuses it in its place.
    """
    numbers = [column[(column >= 1) & (column <= MOST_NESTS)] for column in named]
    return [None] * max((int(column.max(initial=1)) for column in numbers), default=1)


def _read_nests(root: Node) -> tuple[Nest, ...]:
    centres = root.key("tool_nests_mm").items()
    if len(centres) > MOST_NESTS:
        root.key("tool_nests_mm").fail(f"{len(centres)} nests exceed the limit of {MOST_NESTS}")
    if not centres:
        root.key("tool_nests_mm").fail(
            "the list is empty; one entry per tool nest is required, null where unknown"
        )
    uncertainties = _one_or_each(root.key("tool_nest_u_mm"), len(centres))
    axes = root.optional("tool_nest_axis")
    facings = [None] * len(centres) if axes is None else axes.items(len(centres))
    return tuple(
        Nest(
            centre_mm=None if centre.is_null else centre.vector(),
            standard_uncertainty_mm=uncertainty,
            facing=read_direction(facing),
        )
        for centre, uncertainty, facing in zip(centres, uncertainties, facings, strict=True)
    )


def _one_or_each(node: Node, count: int) -> list[float | None]:
    """Read one standard uncertainty for all, or a list with one for each; null = unknown."""
    entries = node.items(count) if isinstance(node.value, list) else (node,) * count
    return [None if entry.is_null else entry.number(least=0.0) for entry in entries]


def _read_fixed_nests(root: Node) -> tuple[FixedNest, ...]:
    centres = root.optional("fixed_nests_certified_mm")
    if centres is None:
        return ()
    entries = centres.items()
    uncertainties = _one_or_each(root.key("fixed_nest_u_mm"), len(entries))
    if None in uncertainties:
        root.key("fixed_nest_u_mm").fail("a certified nest needs a standard uncertainty; it cannot be null")
    return tuple(
        FixedNest(entry.vector(), uncertainty)
        for entry, uncertainty in zip(entries, uncertainties, strict=True)
        if uncertainty is not None
    )


def _read_registration(node: Node) -> WorldRegistration:
    """Read the 6x6 covariance of the world frame [mm, rad]."""
    covariance = read_covariance(node.key("covariance_mm_rad"), 6)
    if np.isnan(covariance).any():
        node.fail("the covariance of the world frame must be known completely")
    return WorldRegistration(covariance)


def _registration_document(registration: WorldRegistration) -> Json:
    return {"covariance_mm_rad": covariance_document(registration.covariance)}


_LENGTH = number(above=0.0)
_ANGLE = Form(lambda node: math.radians(node.number(above=0.0)), degrees)
_STATED = Form(Node.text, lambda text: text or None)  # left out where nobody said it
_CAMPAIGN = (
    Key("base_in_world_nominal", "base_nominal", or_null(PLACEMENT)),
    Key("gravity_m_s2_world", "gravity_m_s2", GRAVITY),
    Key("u_includes_repeatability", "repeatability_in_uncertainty", TRUTH, absent=False),
    Key("tracker_position_world_mm", "tracker_position_mm", VECTOR, absent=None),
    Key("tool_rotation_u_deg", "tool_rotation_uncertainty_rad", _ANGLE, absent=None),
    Key("ballbar_nominal_mm", "ballbar_nominal_mm", _LENGTH, absent=None),
    Key("ballbar_range_mm", "ballbar_range_mm", _LENGTH, absent=None),
    Key("setup_u_mm", "setup_uncertainty_mm", _LENGTH, absent=None),
    Key("robot_serial_number", "robot_serial_number", _STATED, absent=""),
    Key("instrument_serial_number", "instrument_serial_number", _STATED, absent=""),
    Key("measured_on", "measured_on", Form(read_day, date.isoformat), absent=None),
    Key("world_registration", "registration", Form(_read_registration, _registration_document), absent=None),
    Key("notes", "notes", each(TEXT), absent=()),
)


def _read_files(node: Node) -> dict[str, str]:
    files = {}
    for role in node.entries():
        entry = node.optional(role)
        if role in ROLES and entry is not None:
            files[role] = _plain_name(entry)
    if not any(role in files for role in _READING_ROLES):
        node.fail(f"no readings are named; one of {', '.join(_READING_ROLES)} is required", MissingEntryError)
    return files


def _plain_name(node: Node) -> str:
    # The folder may come from anybody: a path in it would have another file of this computer read, and shown
    # in an error.
    name = node.text()
    if name in {".", ".."} or any(mark in name for mark in "/\\:\0"):
        node.fail(f"{name!r} must be the plain name of a file in the campaign folder")
    return name


def _ignored(root: Node) -> Iterator[Message]:
    """Say which keys are kept but not understood; a key of many rows once."""
    for node in root.unlisted(KEYS):
        yield message("ignored.key", name=node.name)
    in_rows = {key: None for row in root.key("dhm_nominal").items() for key in row.entries()}
    for key in in_rows:
        if key not in _JOINT_KEYS:
            yield message("ignored.joint_key", name=key)
    for node in root.key("files").unlisted(ROLES):
        yield message("ignored.role", role=str(node.path[-1]))


def description_document(campaign: Campaign, files: dict[str, str]) -> dict[str, Json]:
    """Return the content of `campaign.json`; optional keys only where the campaign has something to say."""
    robot = campaign.robot
    said: dict[str, Json] = {
        "format": FORMAT,
        "kind": _kind_of(campaign),
        "robot": robot.name,
        "dhm_nominal": joints_document(robot.joints),
        **written_keys(robot, arm_keys(robot.n_joints)),
        **written_keys(campaign, _CAMPAIGN),
        **_nests_document(campaign),
        "simulated": campaign.simulated,
        "files": dict(files),
    }
    return {key: said[key] for key in _IN_ORDER if said[key] is not None or key in _NULL_IF_UNKNOWN}


def _kind_of(campaign: Campaign) -> str:
    if campaign.legs or campaign.validation_legs:
        return "ballbar"
    return "contacts" if campaign.contacts or campaign.validation_contacts else "tracker"


def _nests_document(campaign: Campaign) -> dict[str, Json]:
    nests, fixed = campaign.nests, campaign.fixed_nests
    return {
        "tool_nests_mm": [_listed(nest.centre_mm) for nest in nests],
        "tool_nest_u_mm": _shared([nest.standard_uncertainty_mm for nest in nests]),
        "tool_nest_axis": [_listed(n.facing) for n in nests] if any(n.facing for n in nests) else None,
        "fixed_nests_certified_mm": [list(nest.centre_mm) for nest in fixed] if fixed else None,
        "fixed_nest_u_mm": _shared([nest.standard_uncertainty_mm for nest in fixed]) if fixed else None,
    }


def _listed(vector: Sequence[float] | None) -> Json:
    return None if vector is None else list(vector)


def _shared(uncertainties: Sequence[float | None]) -> Json:
    """Return the one value that all share, or the list where they differ."""
    return uncertainties[0] if len(set(uncertainties)) == 1 else list(uncertainties)
