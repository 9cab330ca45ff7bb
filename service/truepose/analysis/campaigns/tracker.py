"""From sessions to a campaign, and how much it holds: pure, no storage, no clock."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence, Sized
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.analysis.errors import NothingMeasuredError, SessionsDifferError
from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign, FixedNestReadings, PointReadings, Stops
from truepose.domain.robot import WorldRegistration
from truepose.domain.session import FixedNestTaken, PointTaken, Registration
from truepose.messages.catalogue import english
from truepose.messages.message import message
from truepose.storage.records import CampaignSummary, SessionSetup

_MOST_SENTENCES: Final = 100


def summary_of(campaign: Campaign) -> CampaignSummary:
    """Return how much a campaign holds."""
    return CampaignSummary(
        calibration_points=_rows(campaign.calibration),
        validation_points=_rows(campaign.validation),
        calibration_legs=_rows(campaign.legs),
        validation_legs=_rows(campaign.validation_legs),
        calibration_contacts=_rows(campaign.contacts),
        validation_contacts=_rows(campaign.validation_contacts),
        reference_readings=_rows(campaign.reference),
        ignored=_first(tuple(map(english, campaign.ignored))),
        notes=_first(campaign.notes),
        simulated=campaign.simulated,
        measured_on=None if campaign.measured_on is None else campaign.measured_on.isoformat(),
        robot_serial_number=campaign.robot_serial_number or None,
        instrument_serial_number=campaign.instrument_serial_number or None,
    )


def _first(sentences: tuple[str, ...]) -> tuple[str, ...]:
    """Return as many sentences as a list of campaigns can show; the archive keeps all of them."""
    if len(sentences) <= _MOST_SENTENCES:
        return sentences
    more = len(sentences) - _MOST_SENTENCES
    return (*sentences[:_MOST_SENTENCES], f"The archive lists {more} more such remarks.")


def _rows(table: Sized | None) -> int:
    return 0 if table is None else len(table)


@dataclass(frozen=True, slots=True)
class MeasuredSession:
    """What one session left: its set-up and the readings that count."""

    id: int
    setup: SessionSetup
    points: tuple[PointTaken, ...]
    fixed_nests: tuple[FixedNestTaken, ...] = ()
    registration: Registration | None = None


def assemble_campaign(calibration: MeasuredSession, validation: MeasuredSession | None = None) -> Campaign:
    """Return the campaign of a calibration session and, where there is one, of its validation session.

    The joints are the commanded ones: the controller's nominal model turns them into the pose that
    the identified model must correct, and the protocol reports them to 0.01 deg only. Position and
    covariance of the world frame are those of the calibration session's registration.

    Raises
    ------
    NothingMeasuredError
        A session has no reading of a tool nest, or was never registered in the world.
    SessionsDifferError
        The sessions differ in robot, base placement, tool nests or fixed nests.
    """
    sessions = [calibration] if validation is None else [calibration, validation]
    for session in sessions:
        _check_measured(session)
    if validation is not None:
        # Another tool or base would be another model, and its errors would be called errors of this one.
        _check_same_setup(calibration, validation)
    cell, registration = calibration.setup.cell, calibration.registration
    return Campaign(
        robot=cell.robot,
        base_nominal=cell.base_nominal,
        nests=cell.nests,
        calibration=point_readings(calibration.points),
        validation=None if validation is None else point_readings(validation.points),
        reference=_reference([taken for session in sessions for taken in session.fixed_nests]),
        tracker_position_mm=_tracker_position(registration),
        tool_rotation_uncertainty_rad=None if cell.camera is None else cell.camera.artefact_rotation_u_rad,
        fixed_nests=cell.fixed_nests,
        registration=None if registration is None else WorldRegistration(registration.covariance),
        simulated=any(session.setup.simulated for session in sessions),
        robot_serial_number=cell.robot_serial_number,
        # Of the readings, not of the cell file: an instrument may have been exchanged since (decision 0020).
        instrument_serial_number=only_serial(
            point.instrument_serial for session in sessions for point in session.points
        ),
        notes=tuple(_notes(calibration, validation)),
    )


def with_validation_points(
    campaign: Campaign, calibration: MeasuredSession, validation: MeasuredSession
) -> Campaign:
    """Return a campaign of legs with the points of a tracker session that judge its model.

    Raises
    ------
    NothingMeasuredError, SessionsDifferError
        As `assemble_campaign`.
    """
    _check_measured(validation)
    _check_same_setup(calibration, validation)
    return replace(
        campaign,
        validation=point_readings(validation.points),
        reference=_reference(validation.fixed_nests),
        tracker_position_mm=_tracker_position(validation.registration),
        simulated=bool(campaign.simulated) or validation.setup.simulated,
        instrument_serial_number=only_serial([
            campaign.instrument_serial_number,
            *(point.instrument_serial for point in validation.points),
        ]),
        notes=(
            *campaign.notes,
            f"Validation readings from session {validation.id}.",
            *_trackers([validation]),
        ),
    )


def only_serial(serials: Iterable[str]) -> str:
    """Return the serial number of what read all of it; nothing where several did, or it tells none."""
    found = set(serials)
    return found.pop() if len(found) == 1 else ""


def point_readings(points: Sequence[PointTaken]) -> PointReadings:
    """Return readings of tool nests as a table, in the order they were taken."""
    stops = Stops(
        config=np.array([p.config for p in points], dtype=np.int64),
        joints_rad=np.array([p.commanded_rad for p in points], dtype=np.float64),
        direction=np.array([p.direction for p in points], dtype=np.int64),
        time_s=np.array([p.time_s for p in points], dtype=np.float64),
        temperature_c=np.array([p.temperature_c for p in points], dtype=np.float64),
        attachment=np.array([p.attachment for p in points], dtype=np.int64),
        repeat_of=np.array([-1 if p.repeat_of is None else p.repeat_of for p in points], dtype=np.int64),
        group=_groups(points),
    )
    return PointReadings(
        stops=stops,
        nest=np.array([p.nest for p in points], dtype=np.int64),
        position_mm=np.array([p.position_world_mm for p in points], dtype=np.float64),
        standard_uncertainty_mm=np.array([p.standard_uncertainty_mm for p in points], dtype=np.float64),
        covariance_mm2=_covariances(points),
        **_orientations(points),
    )


def _orientations(points: Sequence[PointTaken]) -> dict[str, FloatArray]:
    """Return the orientations of all readings; nothing where an instrument reads none."""
    turns = [p.quaternion for p in points if p.quaternion is not None]
    # An array has a row for every reading; orientations of some of them would need others made up.
    if not points or len(turns) < len(points):
        return {}
    stated = [math.nan if p.rotation_uncertainty_rad is None else p.rotation_uncertainty_rad for p in points]
    return {"quaternion": np.array(turns), "rotation_uncertainty_rad": np.array(stated)}


def _groups(points: Sequence[PointTaken]) -> IntArray | None:
    """Return the group of each reading, shape (n,); None where not every one is in a group."""
    groups = [p.group for p in points if p.group is not None]
    return np.array(groups, dtype=np.int64) if points and len(groups) == len(points) else None


def _covariances(points: Sequence[PointTaken]) -> FloatArray | None:
    """Covariances of all readings, shape (n, 3, 3); None where an instrument states none."""
    stated = [p.covariance_mm2 for p in points]
    if not stated or any(covariance is None for covariance in stated):
        return None
    return np.array(stated, dtype=np.float64)


def _reference(taken: Sequence[FixedNestTaken]) -> FixedNestReadings | None:
    # The readings of the registration made the world frame: they cannot show that it moved.
    looks = [t for t in taken if t.phase == "reference" and t.position_world_mm is not None]
    if not looks:
        return None
    # Two sessions are listed one after the other, and a drift is read along time.
    looks.sort(key=lambda look: look.time_s)
    return FixedNestReadings(
        time_s=np.array([t.time_s for t in looks], dtype=np.float64),
        fixed_nest=np.array([t.fixed_nest for t in looks], dtype=np.int64),
        position_mm=np.array([t.position_world_mm for t in looks], dtype=np.float64),
        standard_uncertainty_mm=np.array([t.standard_uncertainty_mm for t in looks], dtype=np.float64),
    )


def _tracker_position(registration: Registration | None) -> tuple[float, float, float] | None:
    if registration is None:
        return None
    x_mm, y_mm, z_mm = (float(value) for value in registration.translation_mm)
    return x_mm, y_mm, z_mm


def _check_measured(session: MeasuredSession) -> None:
    if not session.points:
        raise NothingMeasuredError(message("refused.no_nest_reading", session=session.id))


def _check_same_setup(calibration: MeasuredSession, validation: MeasuredSession) -> None:
    for word, name in (
        ("robot", "robot"),
        ("base placement", "base_nominal"),
        ("tool nests", "nests"),
        ("fixed nests", "fixed_nests"),
        ("camera", "camera"),
    ):
        if getattr(calibration.setup.cell, name) != getattr(validation.setup.cell, name):
            raise SessionsDifferError(
                message("refused.sessions_differ", first=calibration.id, second=validation.id, what=word)
            )


def _notes(calibration: MeasuredSession, validation: MeasuredSession | None) -> Iterator[str]:
    cell = calibration.setup.cell
    yield f"Calibration readings from session {calibration.id} on {cell.name}."
    if validation is not None:
        yield f"Validation readings from session {validation.id}."
    sessions = [calibration] if validation is None else [calibration, validation]
    if any(session.setup.simulated for session in sessions):
        yield "SIMULATED: no real robot or instrument was used."
    if cell.camera is not None:
        yield (
            "The world frame of the readings is the camera frame, placed at the camera pose stated in the "
            "cell file: absolute positions are positions relative to the camera."
        )
    yield from _trackers(sessions)
    for what, text in (("Load", cell.conditions.load), ("Warm-up", cell.conditions.warm_up)):
        if text:
            yield f"{what}: {text}"
    yield from cell.conditions.notes


def _trackers(sessions: Sequence[MeasuredSession]) -> Iterator[str]:
    """Say which trackers measured, and what that means where there were several."""
    counts = Counter(point.instrument_serial for session in sessions for point in session.points)
    if set(counts) <= {""}:
        return  # they tell no serial number
    if len(counts) == 1:
        (serial,) = counts
        yield f"Tracker: {_tracker_paper(serial, sessions)}"
        return
    yield (
        "More than one tracker was used: each was registered to the world frame separately, and the stated "
        "uncertainty of the world frame is that of the latest registration only."
    )
    for serial, count in counts.items():
        yield f"Tracker: {_tracker_paper(serial, sessions)} Readings: {count}."


def _tracker_paper(serial: str, sessions: Sequence[MeasuredSession]) -> str:
    """Return serial number and certificate: a certificate holds for the number it was stated with."""
    entries = [entry for session in sessions for entry in session.setup.cell.devices]
    found = (entry.certificate for entry in entries if serial and entry.serial_number == serial)
    return f"serial number {serial or 'not stated'}, certificate {next(found, '') or 'not stated'}."
