"""`campaign.json`: everything of a campaign but its tables.

Three optional keys are this program's own. `simulated` is true where no robot and no instrument took part;
where it is absent nobody said so. `measured_on` is the day of the readings, as 2026-03-03. And
`world_registration` is an object with `covariance_mm_rad`, the 6x6 covariance (rows and columns: translation
x y z in mm, rotation vector x y z in rad) of a small motion about the world origin by which the readings may
sit wrong in the world.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.campaign import Campaign
from truepose.domain.robot import FixedNest, Nest, Robot, WorldRegistration
from truepose.exchange.campaigns.origin import read_day, read_simulated
from truepose.exchange.document import Node
from truepose.exchange.errors import MissingEntryError, NewerVersionError, WrongUnitError
from truepose.exchange.json_text import Json
from truepose.exchange.models.covariance import covariance_document, read_covariance
from truepose.exchange.robots.document import (
    joints_document,
    masses_document,
    optional_list,
    placement_document,
    read_direction,
    read_gravity,
    read_joints,
    read_masses,
    read_optional_numbers,
    read_placement,
)

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
)
_READING_ROLES = ("calibration", "validation", "legs", "validation_legs")
_KINDS = ("tracker", "ballbar")
KEYS = frozenset({
    "format", "kind", "robot", "dhm_nominal", "base_in_world_nominal", "tool_nests_mm", "tool_nest_u_mm",
    "masses", "gravity_m_s2_world", "gear_ratio", "typical_compliance_rad_per_Nmm", "robot_repeatability_mm",
    "u_includes_repeatability", "tool_nest_axis", "tracker_position_world_mm", "fixed_nests_certified_mm",
    "fixed_nest_u_mm", "ballbar_nominal_mm", "ballbar_range_mm", "setup_u_mm", "notes", "files",
    "world_registration", "simulated", "measured_on",
})  # fmt: skip
_JOINT_KEYS = frozenset({"joint", "alpha_deg", "a_mm", "theta_offset_deg", "d_mm", "sign"})


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
    robot = _read_robot(root)
    tracker = root.optional("tracker_position_world_mm")
    repeatability_included = root.optional("u_includes_repeatability")
    base = root.key("base_in_world_nominal")
    files = _read_files(root.key("files"))
    campaign = Campaign(
        robot=robot,
        base_nominal=None if base.is_null else read_placement(base),
        nests=_read_nests(root),
        gravity_m_s2=_read_gravity(root),
        repeatability_in_uncertainty=repeatability_included is not None and repeatability_included.truth(),
        tracker_position_mm=None if tracker is None else tracker.vector(),
        fixed_nests=_read_fixed_nests(root),
        registration=_read_registration(root.optional("world_registration")),
        ballbar_nominal_mm=_positive(root, "ballbar_nominal_mm"),
        ballbar_range_mm=_positive(root, "ballbar_range_mm"),
        setup_uncertainty_mm=_read_setup_uncertainty(root, files),
        simulated=read_simulated(root, _read_notes(root)),
        measured_on=read_day(root.optional("measured_on")),
        notes=_read_notes(root),
        ignored=tuple(_ignored(root)),
    )
    return Description(campaign, files, root.key("files"))


def _check_format(root: Node) -> None:
    version = root.key("format")
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
        kind.fail(f"{kind.text()!r} is no kind of campaign; it must be one of {', '.join(_KINDS)}")


def _read_robot(root: Node) -> Robot:
    joints = read_joints(root.key("dhm_nominal"))
    compliances = root.optional("typical_compliance_rad_per_Nmm")
    return Robot(
        name=root.key("robot").text(),
        joints=joints,
        masses=read_masses(root.key("masses"), len(joints)),
        gear_ratios=read_optional_numbers(root.optional("gear_ratio"), len(joints)),
        typical_compliances_rad_per_n_mm=read_optional_numbers(compliances, len(joints)),
        repeatability_mm=root.key("robot_repeatability_mm").number(least=0.0),
    )


def _read_gravity(root: Node) -> tuple[float, float, float]:
    wanted = "gravity_m_s2_world"
    others = [name for name in root.entries() if name.startswith("gravity") and name != wanted]
    if wanted not in root.entries() and others:
        root.child(others[0], None).fail(
            f"key {others[0]} has another frame or unit; {wanted} in m/s2 in the world frame is required",
            WrongUnitError,
        )
    return read_gravity(root.key(wanted))


def _read_nests(root: Node) -> tuple[Nest, ...]:
    centres = root.key("tool_nests_mm").items()
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
        root.key("fixed_nest_u_mm").fail("a certified nest has a standard uncertainty; null is not one")
    return tuple(
        FixedNest(entry.vector(), uncertainty)
        for entry, uncertainty in zip(entries, uncertainties, strict=True)
        if uncertainty is not None
    )


def _read_registration(node: Node | None) -> WorldRegistration | None:
    """Read the 6x6 covariance of the world frame [mm, rad]."""
    if node is None:
        return None
    covariance = read_covariance(node.key("covariance_mm_rad"), 6)
    if np.isnan(covariance).any():
        node.fail("the covariance of the world frame must be known completely")
    return WorldRegistration(covariance)


def _positive(root: Node, name: str) -> float | None:
    node = root.optional(name)
    return None if node is None else node.number(above=0.0)


def _read_setup_uncertainty(root: Node, files: dict[str, str]) -> float | None:
    if "setup" in files and root.optional("setup_u_mm") is None:
        root.fail("key setup_u_mm is missing; it is required where files names a setup", MissingEntryError)
    return _positive(root, "setup_u_mm")


def _read_notes(root: Node) -> tuple[str, ...]:
    notes = root.optional("notes")
    return () if notes is None else tuple(note.text() for note in notes.items())


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
    name = node.text()
    if name in {".", ".."} or any(mark in name for mark in "/\\:\0"):
        node.fail(f"{name!r} must be the plain name of a file in the campaign folder")
    return name


def _ignored(root: Node) -> Iterator[str]:
    """Say which keys are kept but not understood; a key of many rows once."""
    for node in root.unlisted(KEYS):
        yield f"campaign.json: key {node.name} is not part of the format and is ignored."
    in_rows = {key: None for row in root.key("dhm_nominal").items() for key in row.entries()}
    for key in in_rows:
        if key not in _JOINT_KEYS:
            yield f"campaign.json: key {key} of dhm_nominal is not part of the format and is ignored."
    for node in root.key("files").unlisted(ROLES):
        yield f"campaign.json: role {node.path[-1]} of files is not part of the format and is ignored."


def description_document(campaign: Campaign, files: dict[str, str]) -> dict[str, Json]:
    """Return the content of `campaign.json`; optional keys only where the campaign has something to say."""
    robot, base = campaign.robot, campaign.base_nominal
    document: dict[str, Json] = {
        "format": FORMAT,
        "kind": "tracker" if campaign.legs is None and campaign.validation_legs is None else "ballbar",
        "robot": robot.name,
        "dhm_nominal": joints_document(robot.joints),
        "base_in_world_nominal": None if base is None else placement_document(base),
        "tool_nests_mm": [optional_list(nest.centre_mm) for nest in campaign.nests],
        "tool_nest_u_mm": _shared([nest.standard_uncertainty_mm for nest in campaign.nests]),
        "masses": masses_document(robot.masses),
        "gravity_m_s2_world": list(campaign.gravity_m_s2),
        "robot_repeatability_mm": robot.repeatability_mm,
        "u_includes_repeatability": campaign.repeatability_in_uncertainty,
    }
    optional = {key: value for key, value in _optional_keys(campaign).items() if value is not None}
    return {**document, **optional, "notes": list(campaign.notes), "files": dict(files)}


def _optional_keys(campaign: Campaign) -> dict[str, Json]:
    fixed, registration = campaign.fixed_nests, campaign.registration
    axes: Json = [optional_list(nest.facing) for nest in campaign.nests]
    return {
        "gear_ratio": optional_list(campaign.robot.gear_ratios),
        "typical_compliance_rad_per_Nmm": optional_list(campaign.robot.typical_compliances_rad_per_n_mm),
        "tool_nest_axis": axes if any(nest.facing for nest in campaign.nests) else None,
        "tracker_position_world_mm": optional_list(campaign.tracker_position_mm),
        "fixed_nests_certified_mm": [list(nest.centre_mm) for nest in fixed] if fixed else None,
        "fixed_nest_u_mm": _shared([nest.standard_uncertainty_mm for nest in fixed]) if fixed else None,
        "ballbar_nominal_mm": campaign.ballbar_nominal_mm,
        "ballbar_range_mm": campaign.ballbar_range_mm,
        "setup_u_mm": campaign.setup_uncertainty_mm,
        "simulated": campaign.simulated,
        "measured_on": None if campaign.measured_on is None else campaign.measured_on.isoformat(),
        "world_registration": None
        if registration is None
        else {"covariance_mm_rad": covariance_document(registration.covariance)},
    }


def _shared(uncertainties: Sequence[float | None]) -> Json:
    """Return the one value that all share, or the list where they differ."""
    return uncertainties[0] if len(set(uncertainties)) == 1 else list(uncertainties)
