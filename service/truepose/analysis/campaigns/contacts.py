"""From a session of closed loops to a campaign: pure, no storage, no clock."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

import numpy as np

from truepose.analysis.campaigns.tracker import only_serial
from truepose.analysis.errors import NothingMeasuredError, SessionsDifferError
from truepose.domain.campaign import NO_AXIS, Campaign, ContactReadings, Stops, TargetDistances
from truepose.domain.contacts import ContactPlan, ContactTaken, TargetDistance
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.messages.message import message
from truepose.storage.records import SessionSetup


def readings_of(entries: Iterable[LedgerEntry]) -> tuple[ContactTaken, ...]:
    """Return what was read, oldest first."""
    lines = (entry.contact for entry in entries if entry.kind is EntryKind.MEASURED)
    return tuple(contact for contact in lines if contact is not None)


def contact_campaign(
    name: str,
    setup: SessionSetup,
    plan: ContactPlan,
    taken: Sequence[ContactTaken],
    gauges: Collection[str] = (),
) -> Campaign:
    """Return the campaign of what was read in a session; the joints are the commanded ones.

    `gauges` are the devices of the cell that read. Raises NothingMeasuredError where nothing was.
    """
    if not taken:
        raise NothingMeasuredError(message("refused.no_reading", name=name))
    cell = setup.cell
    return Campaign(
        robot=cell.robot,
        base_nominal=cell.base_nominal,
        nests=cell.nests,
        contacts=contact_readings(taken),
        targets=tuple(
            # What the fit shall find is not stated as known.
            replace(target, zero_mm=None) if target.number in plan.found_zeros else target
            for target in plan.targets
        ),
        target_distances=_distances(plan.distances),
        simulated=setup.simulated,
        robot_serial_number=cell.robot_serial_number,
        # A session does not begin with a gauge of another number than the cell names.
        instrument_serial_number=only_serial(
            entry.serial_number for entry in cell.devices if entry.name in gauges
        ),
        notes=(f"Contacts from {name}: {plan.loop}.",),
    )


def judged_by_contacts(
    campaign: Campaign, plans: tuple[ContactPlan, ContactPlan], name: str, taken: Sequence[ContactTaken]
) -> Campaign:
    """Return a campaign with the contacts of another session at the same fixture, which judge its model.

    Raises NothingMeasuredError, SessionsDifferError.
    """
    if plans[0].targets != plans[1].targets or plans[0].nest != plans[1].nest:
        raise SessionsDifferError(message("refused.other_targets", name=name))
    if not taken:
        raise NothingMeasuredError(message("refused.no_reading", name=name))
    notes = (*campaign.notes, f"Validation contacts from {name}.")
    return replace(campaign, validation_contacts=contact_readings(taken), notes=notes)


def contact_readings(taken: Sequence[ContactTaken]) -> ContactReadings:
    """Return readings as a table, those of a stop one after the other."""
    rows = [(one, number) for one in taken for number in range(len(one.reading_mm))]
    stops = Stops(
        config=np.array([one.config for one, _ in rows], dtype=np.int64),
        joints_rad=np.array([one.commanded_rad for one, _ in rows], dtype=np.float64),
        direction=np.array([one.direction for one, _ in rows], dtype=np.int64),
        time_s=np.array([one.time_s for one, _ in rows], dtype=np.float64),
        attachment=np.array([one.attachment for one, _ in rows], dtype=np.int64),
    )
    along_axes = any(one.axes for one in taken)
    axes = [one.axes[number] if one.axes else NO_AXIS for one, number in rows]
    return ContactReadings(
        stops=stops,
        target=np.array([one.targets[number] for one, number in rows], dtype=np.int64),
        nest=np.array([one.nest for one, _ in rows], dtype=np.int64),
        reading_mm=np.array([one.reading_mm[number] for one, number in rows], dtype=np.float64),
        standard_uncertainty_mm=np.array([one.standard_uncertainty_mm for one, _ in rows], dtype=np.float64),
        axis=np.array(axes, dtype=np.int64) if along_axes else None,
    )


def _distances(distances: Sequence[TargetDistance]) -> TargetDistances | None:
    if not distances:
        return None
    return TargetDistances(
        target_a=np.array([distance.targets[0] for distance in distances], dtype=np.int64),
        target_b=np.array([distance.targets[1] for distance in distances], dtype=np.int64),
        distance_mm=np.array([distance.distance_mm for distance in distances], dtype=np.float64),
        standard_uncertainty_mm=np.array([one.standard_uncertainty_mm for one in distances]),
    )
