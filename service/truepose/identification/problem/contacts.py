"""Identification from closed loops: readings against targets whose places are parameters too.

Targets, unknown nests and the sensor's turn are found without a starting guess. With the nominal arm (R_n,
o_n) at stop n and the nest t that takes part, the tool is at P_n = o_n + R_n t. For given nests every kind of
target has a start that is linear in it (`observations.contact_targets`); a coarse set of nests is tried where
one is unknown, and what fits best is refined with a loss that far readings do not bend. An arm that comes to
each target k at one place C_k (gauges of a few millimetres' travel, small spheres) tells its nests at once:

    o_n + R_n t - C_k = 0        linear in t and C_k

A sensor's turn in the tool is what turns the places of the ball, as seen from it, onto its readings.
"""

from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, distinct_values
from truepose.domain.campaign import Campaign, ContactReadings
from truepose.domain.contacts import SEEN_ALONG_AXES, Target, TargetKind
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import FramePlacement
from truepose.effects.frames.base_frame import NAME as BASE
from truepose.effects.ports import Setting
from truepose.identification.model.structure import TARGET_OWNER, Structure, target_prefix
from truepose.identification.observations.blocks import ObservationBlock
from truepose.identification.observations.contact_targets import KINDS, Probe, sensor_axes
from truepose.identification.observations.contacts import contact_block, distance_block
from truepose.identification.problem.initial_frames import Placement
from truepose.identification.problem.legs import attachments
from truepose.identification.problem.problem_setup import (
    known_placement,
    started_structure,
    with_certified_nests,
)
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import (
    placement_rotation,
    placement_translation,
    rotation_from_vector,
    vector_from_rotation,
)

_REFINED = 4  # starts
_SCALE_MM = 2.0  # residuals beyond this count linearly: the size of a nominal robot's errors
_SUBSET = 400  # readings used for the search; plenty for some twenty unknowns


@dataclass(frozen=True, slots=True)
class ContactPlacement:
    """Where the nominal robot puts targets and nests, and how it turns the sensor.

    Attributes
    ----------
    targets : tuple of Target
        About what the parameters of each count from.
    values : tuple of ndarray
        Of the parameters of each, internal units.
    nests_mm : ndarray, shape (K, 3)
        Flange frame.
    tool_rotation : ndarray, shape (3, 3)
        In the flange frame.
    """

    targets: tuple[Target, ...]
    values: tuple[FloatArray, ...]
    nests_mm: FloatArray
    tool_rotation: FloatArray


@dataclass(frozen=True, slots=True)
class Contacts:
    """What was read, as the search looks at it.

    Attributes
    ----------
    rotation : ndarray, shape (n, 3, 3)
        Of the flange frame in the world, nominal.
    origin_mm : ndarray, shape (n, 3)
        Of the flange frame.
    nest : ndarray of int, shape (n,)
        1-based.
    target : ndarray of int, shape (n,)
        Index in `targets`.
    axis : ndarray of int, shape (n,)
        Of the sensor, NO_AXIS where it has none.
    reading_mm : ndarray, shape (n,)
    nests_mm : ndarray, shape (K, 3)
        Flange frame; rows of unknown nests are ignored.
    nest_unknown : ndarray of bool, shape (K,)
    targets : tuple of Target
    """

    rotation: FloatArray
    origin_mm: FloatArray
    nest: IntArray
    target: IntArray
    axis: IntArray
    reading_mm: FloatArray
    nests_mm: FloatArray
    nest_unknown: BoolArray
    targets: tuple[Target, ...]

    @property
    def turning(self) -> bool:
        """Whether how the sensor is turned shows in them."""
        return any(target.kind in SEEN_ALONG_AXES for target in self.targets)

    def answer(self, unknowns: "_Unknowns") -> ContactPlacement:
        """Return what unknowns stand for."""
        nests = self.nests_mm.copy()
        # Certified nests stay: in a search of millimetres their certificates are exact.
        nests[self.nest_unknown] = unknowns.nests_mm
        return ContactPlacement(
            unknowns.targets, unknowns.values, nests, rotation_from_vector(unknowns.turn[None])[0]
        )

    def probe(self, placement: ContactPlacement) -> Probe:
        """Return where the tool was."""
        nests = placement.nests_mm[self.nest - 1]
        place = self.origin_mm + np.einsum("nij,nj->ni", self.rotation, nests)
        return Probe(place, sensor_axes(self.rotation @ placement.tool_rotation, self.axis))

    def residual(self, unknowns: "_Unknowns") -> FloatArray:
        """Return what is left of the readings, observed minus predicted [mm], shape (n,)."""
        placement = self.answer(unknowns)
        # What effects say is read too much is left to the fit: the search knows no parameters of theirs.
        probe, left = self.probe(placement), self.reading_mm.copy()
        for number, (target, own) in enumerate(zip(placement.targets, placement.values, strict=True)):
            rows = np.flatnonzero(self.target == number)
            left[rows] -= KINDS[target.kind].reading_mm(target, own, probe.taken(rows))
        return left


@dataclass(frozen=True, slots=True)
class _Unknowns:
    targets: tuple[Target, ...]
    values: tuple[FloatArray, ...]
    nests_mm: FloatArray  # (U, 3)
    turn: FloatArray  # (3,) rotation vector

    def packed(self, *, turning: bool) -> FloatArray:
        return np.concatenate([*self.values, self.nests_mm.ravel(), self.turn if turning else np.zeros(0)])

    def unpacked(self, packed: FloatArray) -> "_Unknowns":
        ends = np.cumsum([len(own) for own in self.values])
        *values, rest = np.split(packed, ends)
        split = self.nests_mm.size
        turn = rest[split:] if len(rest) > split else self.turn
        return _Unknowns(self.targets, tuple(values), rest[:split].reshape(-1, 3), turn)


def place_contacts(contacts: Contacts) -> ContactPlacement:
    """Find targets, unknown nests and the turn of a sensor for the nominal robot.

    Parameters
    ----------
    contacts : Contacts
        n readings, and the nominal arm at each.

    Returns
    -------
    ContactPlacement
        Of the smallest median residual among the starts that were refined.
    """
    starts = [_started(contacts, nests) for nests in _nests_to_try(contacts)]
    starts.sort(key=lambda start: _typical(contacts, start))
    ends = [_refined(contacts, start) for start in starts[:_REFINED]]
    # A turn is told from targets that are in place already, and may be far from the one they were placed
    # with.
    if contacts.turning:
        ends += [_refined(contacts, _turned(contacts, end)) for end in ends]
    return _centred(contacts.answer(min(ends, key=lambda end: _typical(contacts, end))))


def _centred(found: ContactPlacement) -> ContactPlacement:
    """Return what was found with each target where it was found, wherever it was looked for first."""
    each = [
        KINDS[target.kind].centred(target, values)
        for target, values in zip(found.targets, found.values, strict=True)
    ]
    # The fit begins where the search ended, and priors are about there.
    targets, values = zip(*each, strict=True)
    return replace(found, targets=targets, values=values)


def _nests_to_try(contacts: Contacts) -> list[FloatArray]:
    """Return places of the unknown nests to begin with, shape (U, 3) each."""
    unknown = int(contacts.nest_unknown.sum())
    tried = [np.tile(nest, (unknown, 1)) for nest in attachments(unknown > 0)]
    return [_at_one_place(contacts), *tried] if unknown else tried


def _at_one_place(contacts: Contacts) -> FloatArray:
    """Return the unknown nests of an arm that comes to each target at one place, shape (U, 3).

    So it does with gauges of a few millimetres' travel, small spheres and sensors: o + R t is the same at all
    stops of a target, which is linear in the nests t and these places.
    """
    n, numbers = len(contacts.nest), np.flatnonzero(contacts.nest_unknown)
    known = np.where(contacts.nest_unknown[:, None], 0.0, contacts.nests_mm)[contacts.nest - 1]
    of_nests = [np.where((contacts.nest == k + 1)[:, None, None], contacts.rotation, 0.0) for k in numbers]
    of_places = [
        np.where((contacts.target == k)[:, None, None], -np.eye(3), 0.0) for k in range(len(contacts.targets))
    ]
    design = np.concatenate([*of_nests, *of_places], axis=2).reshape(3 * n, -1)
    right = -(contacts.origin_mm + np.einsum("nij,nj->ni", contacts.rotation, known)).reshape(-1)
    found: FloatArray = np.linalg.lstsq(design, right, rcond=1e-9)[0]
    return found[: 3 * len(numbers)].reshape(-1, 3)


def _started(contacts: Contacts, unknown: FloatArray) -> _Unknowns:
    start = _Unknowns(contacts.targets, (), unknown, np.zeros(3))
    probe = contacts.probe(contacts.answer(start))
    # For given nests each target is found by itself, from its own readings.
    found = []
    for number, target in enumerate(contacts.targets):
        rows = np.flatnonzero(contacts.target == number)
        found.append(KINDS[target.kind].started(target, probe.taken(rows), contacts.reading_mm[rows]))
    return _Unknowns(tuple(t for t, _ in found), tuple(values for _, values in found), unknown, start.turn)


def _typical(contacts: Contacts, unknowns: _Unknowns) -> float:
    return float(np.median(np.abs(contacts.residual(unknowns))))


def _refined(contacts: Contacts, start: _Unknowns) -> _Unknowns:
    from scipy.optimize import least_squares  # its import takes longer than a campaign of points needs

    def residual(packed: FloatArray) -> FloatArray:
        return contacts.residual(start.unpacked(packed))

    end = least_squares(
        residual,
        start.packed(turning=contacts.turning),
        # Squares of readings that were confused would draw targets towards them.
        loss="soft_l1",
        f_scale=_SCALE_MM,
        max_nfev=60,
        x_scale="jac",
    )
    return start.unpacked(np.asarray(end.x))


def _turned(contacts: Contacts, unknowns: _Unknowns) -> _Unknowns:
    """Return unknowns whose sensor is turned so that it sees the balls where it read them.

    The best rotation between two sets of vectors: W. Kabsch, Acta Cryst. A 32, 1976, 922-923.
    """
    placement = contacts.answer(unknowns)
    probe = contacts.probe(placement)
    sums = np.zeros((3, 3))
    for number, (target, centre) in enumerate(zip(placement.targets, placement.values, strict=True)):
        if target.kind is TargetKind.BALL:
            rows = np.flatnonzero(contacts.target == number)
            arm = centre - probe.place_mm[rows]
            seen = np.einsum("nji,nj->ni", contacts.rotation[rows], arm)
            read = np.eye(3)[contacts.axis[rows]] * contacts.reading_mm[rows, None]
            sums += seen.T @ read
    left, _, right = np.linalg.svd(sums)
    # Without the sign the best match might be a mirror image.
    rotation = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    turn = vector_from_rotation(rotation[None])[0]
    return _Unknowns(unknowns.targets, unknowns.values, unknowns.nests_mm, turn)


def spread_over_targets(target: IntArray) -> IntArray:
    """Return rows of every target, few enough to search with.

    Parameters
    ----------
    target : ndarray of int, shape (n,)
        Number or index of each reading's target.

    Returns
    -------
    ndarray of int, shape (m,)
        In order; 30 of each target at least, where it has as many.
    """
    numbers = distinct_values(target)
    most = max(30, _SUBSET // len(numbers))
    chosen = []
    for number in numbers.tolist():
        rows = np.flatnonzero(target == number)
        # Evenly, as a session goes through its zone: the first rows alone would see a part of it.
        spread = np.linspace(0, len(rows) - 1, min(len(rows), most)).astype(np.int64)
        chosen.append(rows[distinct_values(spread)])
    return np.sort(np.concatenate(chosen))


def contact_structure(
    campaign: Campaign, contacts: ContactReadings, effects: tuple[str, ...], setting: Setting
) -> tuple[Structure, tuple[ObservationBlock, ...], FloatArray]:
    """Place targets and unknown nests, and return structure, observations and start values.

    The contacts come first; certified distances follow where the campaign has them.

    Parameters
    ----------
    campaign : Campaign
    contacts : ContactReadings
        Of the campaign.
    effects : tuple of str
    setting : Setting
        Of campaign and stops.

    Returns
    -------
    structure : Structure
    blocks : tuple of Block
    start : ndarray, shape (P,)
        Internal units.

    Raises
    ------
    ConfigurationError
        The base is to be identified, which contacts with targets of unknown place do not see.
    """
    if BASE in effects:
        raise ConfigurationError(
            "Contacts with targets at unknown positions cannot determine the base position. Leave `base` out "
            "of the effects."
        )
    # Nobody can tell the world from the base: without a stated one they are the same.
    base = campaign.base_nominal or FramePlacement()
    campaign = replace(campaign, base_nominal=base)
    found = _placed(campaign, contacts, base)
    placement = Placement(
        placement_rotation(base),
        placement_translation(base),
        found.nests_mm,
        np.zeros((0, 3)),
        np.zeros(0),
    )
    structure, start = started_structure(campaign, effects, placement, found.tool_rotation, setting)
    structure, start = with_certified_nests(structure, start, campaign, contacts.nest)
    structure, start = _with_targets(structure, start, found)
    blocks: list[ObservationBlock] = [contact_block(contacts, campaign.scatter_mm, structure.targets)]
    if campaign.target_distances is not None:
        certified = distance_block(campaign.target_distances, structure.targets, campaign.robot)
        blocks += [] if certified is None else [certified]
    return structure, tuple(blocks), start


def _placed(campaign: Campaign, contacts: ContactReadings, base: FramePlacement) -> ContactPlacement:
    touched = distinct_values(contacts.target)
    targets = tuple(target for target in campaign.targets if target.number in touched)
    index = np.searchsorted(touched, contacts.target)
    targets = tuple(sorted(targets, key=_number))
    # The search need not see thousands of readings: the fit that follows does.
    few = spread_over_targets(index)
    nominal = nominal_values(campaign.robot, contacts.stops.joints_rad[few])
    chain = forward(nominal, placement_rotation(base), placement_translation(base))
    known = known_placement(campaign)
    return place_contacts(
        Contacts(
            rotation=chain.end_rotation,
            origin_mm=chain.end_origin,
            nest=contacts.nest[few],
            target=index[few],
            axis=contacts.axes[few],
            reading_mm=contacts.reading_mm[few],
            nests_mm=known.nests_mm,
            nest_unknown=known.nest_unknown,
            targets=targets,
        )
    )


def _number(target: Target) -> int:
    return target.number


def _with_targets(
    structure: Structure, start: FloatArray, found: ContactPlacement
) -> tuple[Structure, FloatArray]:
    # About what was found: a certificate alone holds a target to a stated number.
    specs = tuple(
        spec._replace(name=f"{target_prefix(target)}{spec.name}")
        for target, values in zip(found.targets, found.values, strict=True)
        for spec in KINDS[target.kind].parameters(target, values)
    )
    # Last, so that what effects and certificates number before them stays.
    widened = replace(
        structure,
        specs=structure.specs + specs,
        owners=structure.owners + (TARGET_OWNER,) * len(specs),
        targets=found.targets,
    )
    return widened, np.concatenate([start, *found.values])
