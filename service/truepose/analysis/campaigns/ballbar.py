"""From what counts of a ballbar session to a campaign: pure, no storage, no clock."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from truepose.analysis.campaigns.tracker import only_serial
from truepose.analysis.errors import NothingMeasuredError
from truepose.domain.ballbar import ArrivalTaken, Leg, LengthTaken
from truepose.domain.campaign import Campaign, CupSetups, FixtureLengths, LegReadings, Stops
from truepose.domain.cell import Artefact, BallbarKit
from truepose.messages.message import message
from truepose.storage.records import SessionSetup

_TOOL = 0  # placement of the tool's triangle in a campaign


@dataclass(frozen=True, slots=True)
class ValidLength:
    """A leg that counts, and where the arm stood."""

    placement: int
    config: int
    attempt: int
    leg: Leg
    length: LengthTaken
    arrival: ArrivalTaken
    stop: int  # number in the campaign: another attempt at a pose is another stop of the arm


@dataclass(frozen=True, slots=True)
class ValidSide:
    """A side of a triangle that counts."""

    placement: int  # 0: the tool's
    points: tuple[int, int]
    length: LengthTaken


@dataclass(frozen=True, slots=True)
class ValidCupSetup:
    """Where the arm held the ball while a cup was clamped on it."""

    placement: int
    base_point: int
    arrival: ArrivalTaken


@dataclass(frozen=True, slots=True)
class RestPose:
    """Where the arm came to rest last."""

    placement: int  # of the base fixture at that time
    joints_rad: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ValidReadings:
    """What counts of a session: nothing superseded, nothing skipped, no pose whose legs were exchanged."""

    legs: tuple[ValidLength, ...] = ()
    sides: tuple[ValidSide, ...] = ()
    setups: tuple[ValidCupSetup, ...] = ()
    skipped: tuple[str, ...] = ()  # a sentence each
    exchanged: tuple[int, ...] = ()  # poses left out because their legs were confused
    standing: RestPose | None = None  # None: the arm has not moved yet


def assemble_ballbar_campaign(
    name: str, setup: SessionSetup, kit: BallbarKit, counting: ValidReadings
) -> Campaign:
    """Return the campaign of a ballbar session.

    The joints are the commanded ones: the controller's nominal model turns them into the pose that the
    identified model must correct. Lengths carry the uncertainty with which they were stored.

    Parameters
    ----------
    name : str
        Where the readings come from, for the notes.
    setup : SessionSetup
    kit : BallbarKit
    counting : ValidReadings

    Raises
    ------
    NothingMeasuredError
        No leg counts.
    """
    if not counting.legs:
        raise NothingMeasuredError(message("refused.no_length", name=name))
    cell = setup.cell
    return Campaign(
        robot=cell.robot,
        base_nominal=cell.base_nominal,
        nests=cell.nests,
        legs=leg_readings(counting.legs, setup.attachment),
        fixture=_fixture(counting.sides),
        setup=_setups(counting.setups),
        ballbar_nominal_mm=kit.base_bars.nominal_mm,
        ballbar_range_mm=kit.range_mm,
        setup_uncertainty_mm=kit.setup_u_mm,
        simulated=setup.simulated,
        robot_serial_number=cell.robot_serial_number,
        instrument_serial_number=only_serial(kept.length.instrument_serial for kept in counting.legs),
        notes=tuple(_notes(name, setup, kit, counting)),
    )


def leg_readings(legs: Sequence[ValidLength], attachment: int) -> LegReadings:
    """Return legs as a table, in the order they were measured."""
    stops = Stops(
        config=np.array([kept.stop for kept in legs], dtype=np.int64),
        joints_rad=np.array([kept.arrival.commanded_rad for kept in legs], dtype=np.float64),
        direction=np.array([kept.arrival.direction for kept in legs], dtype=np.int64),
        time_s=np.array([kept.length.time_s for kept in legs], dtype=np.float64),
        temperature_c=np.array([kept.length.temperature_c for kept in legs], dtype=np.float64),
        attachment=np.full(len(legs), attachment, dtype=np.int64),
    )
    return LegReadings(
        stops=stops,
        placement=np.array([kept.placement for kept in legs], dtype=np.int64),
        base_point=np.array([kept.leg[0] for kept in legs], dtype=np.int64),
        nest=np.array([kept.leg[1] for kept in legs], dtype=np.int64),
        length_mm=np.array([kept.length.length_mm for kept in legs], dtype=np.float64),
        standard_uncertainty_mm=np.array(
            [kept.length.standard_uncertainty_mm for kept in legs], dtype=np.float64
        ),
        initialisation=np.array([kept.length.initialisation for kept in legs], dtype=np.int64),
    )


def _fixture(sides: Sequence[ValidSide]) -> FixtureLengths | None:
    if not sides:
        return None
    return FixtureLengths(
        placement=np.array([side.placement for side in sides], dtype=np.int64),
        point_a=np.array([side.points[0] for side in sides], dtype=np.int64),
        point_b=np.array([side.points[1] for side in sides], dtype=np.int64),
        length_mm=np.array([side.length.length_mm for side in sides], dtype=np.float64),
        standard_uncertainty_mm=np.array(
            [side.length.standard_uncertainty_mm for side in sides], dtype=np.float64
        ),
    )


def _setups(setups: Sequence[ValidCupSetup]) -> CupSetups | None:
    if not setups:
        return None
    return CupSetups(
        placement=np.array([kept.placement for kept in setups], dtype=np.int64),
        base_point=np.array([kept.base_point for kept in setups], dtype=np.int64),
        joints_rad=np.array([kept.arrival.commanded_rad for kept in setups], dtype=np.float64),
    )


def _notes(name: str, setup: SessionSetup, kit: BallbarKit, counting: ValidReadings) -> Iterator[str]:
    cell = setup.cell
    yield f"Ballbar lengths from {name} on {cell.name}."
    if setup.simulated:
        yield "SIMULATED: no real robot or instrument was used."
    lengths = [side.length for side in counting.sides] + [leg.length for leg in counting.legs]
    yield from _ballbars(kit.instrument, lengths)
    yield f"Calibrator: {_paper(kit.calibrator)}"
    for bars in (kit.tool_bars, kit.base_bars):
        yield (
            f"Lengths of {bars.nominal_mm:g} mm are referred to a calibrator of {bars.calibrator_mm:.4f} mm "
            f"(standard uncertainty {bars.calibrator_u_mm:.4f} mm)."
        )
    if counting.exchanged:
        numbers = ", ".join(str(config) for config in counting.exchanged)
        yield f"Left out because their lengths had been swapped: poses {numbers}."
    yield from counting.skipped
    yield from cell.conditions.notes


def _ballbars(owner: Artefact, lengths: Sequence[LengthTaken]) -> Iterator[str]:
    """Say which ballbars measured: the paper of the owner's own, and of another what is not known of it."""
    kept_with = Counter((length.instrument_serial, _has_paper(length, owner)) for length in lengths)
    if len(kept_with) > 1:
        yield "More than one ballbar was used; each length is referred to the zero of its own instrument."
    for (serial, has_paper), count in kept_with.items():
        if has_paper:
            yield f"Ballbar: {_paper(owner, serial)}"
            continue
        u_mm = max(
            length.standard_uncertainty_mm
            for length in lengths
            if length.instrument_serial == serial and not _has_paper(length, owner)
        )
        yield (
            f"Ballbar without a certificate, serial number {serial or 'not stated'}: the accuracy of its "
            f"lengths is unknown. Lengths used: {count}, with a standard uncertainty of up to {u_mm:.4f} mm."
        )


def _has_paper(length: LengthTaken, owner: Artefact) -> bool:
    """Whether a length was kept with the paper of the owner's ballbar."""
    # A certificate holds for the instrument that it names (decision 0020); without one the serial number has
    # to tell.
    if owner.certificate:
        return length.certificate == owner.certificate
    own = owner.serial_number.casefold()
    return not own or length.instrument_serial.casefold() == own


def _paper(artefact: Artefact, serial: str = "") -> str:
    """Return what an artefact is and what says that its numbers hold, as one sentence."""
    parts = [
        artefact.name,
        f"serial number {serial or artefact.serial_number or 'not stated'}",
        f"certificate {artefact.certificate or 'not stated'}",
        f"valid until {artefact.certificate_expires}" if artefact.certificate_expires else "",
    ]
    return ", ".join(part for part in parts if part) + "."
