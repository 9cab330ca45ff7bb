"""The tracker as the session uses it: one face at a time, asked who it is, and no answer taken on trust."""

import math
from typing import Final, Literal

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.ledger import EntryKind
from truepose.domain.session import IdentityOf, IdentityTaken, Registration, Vector
from truepose.messages.message import Text, message
from truepose.sessions.engine.identity_check import (
    acceptance_entry,
    reported_serial_number,
    same_number,
    sentence,
)
from truepose.sessions.engine.ledger import IdentityCheck
from truepose.sessions.engine.nominal_arm import as_vector
from truepose.sessions.errors import (
    ForeignInstrumentError,
    ForeignRobotError,
    NotNowError,
    ReadingRejectedError,
)
from truepose_drivers.api import Device, DeviceIdentity, Environment, PointTracker, TrackerReading
from truepose_drivers.errors import DeviceRefusedError, MeasurementFailedError, NotInitialisedError


class TrackerIdentityCheck(IdentityCheck):
    """Asks devices who they are and keeps what is new about it."""

    _permitted: tuple[str, str] | None = None  # serial number and person, until it is asked again

    @property
    def question(self) -> Text | None:
        """What a person is asked about the tracker; None where nothing is."""
        return None if self.tracker_in_question is None else sentence(self.tracker_in_question)

    @property
    def tracker_in_question(self) -> IdentityTaken | None:
        """Another tracker than the expected one, until a person accepts it."""
        return self._foreign("tracker")

    def require_questioned(self, serial: str) -> None:
        """Raise NotNowError where nobody asks whether this tracker may measure; no number is none."""
        foreign = self.tracker_in_question
        if serial and (foreign is None or not same_number(serial, foreign.serial)):
            raise NotNowError(message("session.refused.tracker_not_asked", serial=serial))

    def permit(self, serial: str, person: str) -> None:
        """Take the tracker of this serial number where it answers next: a person accepts it."""
        self._permitted = (serial, person) if serial else None

    async def meet(self, device: IdentityOf, link: Device) -> DeviceIdentity:
        """Ask a device who it is.

        Raises ForeignInstrumentError, ForeignRobotError, or what the driver raises; what was found is on
        disk by then.
        """
        identity = await link.identify()
        self.hear(device, identity)
        found = self.news(device, identity)
        # A permission is for the next answer alone: later another one may have this address.
        permitted, self._permitted = self._permitted, None
        if found is not None:
            await self._note(found)
        foreign = self._foreign(device)
        if foreign is None:
            return identity
        # Accepted is the number that the person named, not whoever answers (decision 0020).
        if permitted is None or not same_number(permitted[0], reported_serial_number(identity.serial)):
            raise _refusal(foreign)
        await self._note(acceptance_entry(foreign, permitted[1]))
        return identity

    def _foreign(self, device: IdentityOf) -> IdentityTaken | None:
        return self._logbook.record.known(device).foreign

    async def _note(self, found: IdentityTaken) -> None:
        # who was met first is introduced anyway
        kind = EntryKind.CONTROL if found.finding == "first" else EntryKind.NOTED
        await self._logbook.write(kind, text=sentence(found), identity=found)


def _refusal(foreign: IdentityTaken) -> ForeignInstrumentError | ForeignRobotError:
    if foreign.device == "robot":
        return ForeignRobotError(sentence(foreign))
    return ForeignInstrumentError(foreign, sentence(foreign))


_SMALLEST_UNCERTAINTY_MM: Final = 1e-4  # last digit that trackers give; keeps weights finite


class CheckedTracker:
    """Measures on the face that is asked for, and refuses readings that are no numbers, or another's."""

    def __init__(self, tracker: PointTracker, identities: TrackerIdentityCheck) -> None:
        self._tracker = tracker
        self._identities = identities
        self.serial = ""  # of the one that took the last reading

    async def find(self, place_mm: FloatArray, radius_mm: float) -> None:
        """Lock on the reflector near a place of the tracker's frame; raises ReflectorNotFoundError."""
        await self._tracker.find_reflector(as_vector(place_mm), search_radius_mm=radius_mm)

    async def measure(self, duration_s: float, face: Literal[1, 2] = 1) -> TrackerReading:
        """Measure on `face`, turning to it first where the instrument stands on the other one."""
        reading = await self._measure(duration_s)
        if reading.face != face:
            await self._tracker.change_face()
            # The first reading only says on which face the instrument stands; it was taken on the wrong one.
            reading = await self._measure(duration_s)
        if reading.face != face:
            raise ReadingRejectedError(message("session.tracker.face", face=reading.face, wanted=face))
        # asked after the reading: one that was exchanged meanwhile behind the same address is seen
        self.serial = reported_serial_number((await self._identities.meet("tracker", self._tracker)).serial)
        return reading

    async def _measure(self, duration_s: float) -> TrackerReading:
        reading = await self._tracker.measure_point(duration_s=duration_s)
        if not all(math.isfinite(value) for value in (*reading.point_mm, reading.time_s)):
            raise ReadingRejectedError(message("session.tracker.not_finite"))
        return reading

    async def temperature_c(self) -> float:
        """Return the air temperature, NaN where the tracker has no weather station."""
        air = await self.environment()
        return math.nan if air is None else air.temperature_c

    async def environment(self) -> Environment | None:
        """Return the air as the weather station states it, None where the tracker has none."""
        try:
            return await self._tracker.environment()
        # An instrument that forgot its initialisation is no instrument without a weather station.
        except NotInitialisedError:
            raise
        except (DeviceRefusedError, MeasurementFailedError):
            return None


def standard_uncertainty_mm(reading: TrackerReading) -> float:
    """Return the standard uncertainty per axis of one reading [mm].

    Root mean square over the axes of the accuracy model's covariance; without one of what the
    instrument states for its axes; without that of the scatter of its samples, as that of their mean.
    """
    if reading.covariance_mm2 is not None:
        return float(np.sqrt(np.trace(np.array(reading.covariance_mm2)) / 3.0))
    stated = float(np.sqrt(np.mean(np.square(reading.standard_deviation_mm))))
    if not math.isfinite(stated):
        stated = reading.rms_mm / math.sqrt(3.0 * max(1, reading.samples))
    return stated if stated > _SMALLEST_UNCERTAINTY_MM else _SMALLEST_UNCERTAINTY_MM


def stated_covariance_mm2(reading: TrackerReading) -> FloatArray:
    """Return what the instrument states of one reading, tracker frame, shape (3, 3); NaN for nothing."""
    if reading.covariance_mm2 is not None:
        return np.array(reading.covariance_mm2)
    return np.diag(np.square(reading.standard_deviation_mm))


def world_covariance_mm2(
    reading: TrackerReading, registration: Registration
) -> tuple[Vector, Vector, Vector] | None:
    """Return R C R' of a reading [mm2], which turns its covariance into the world; None where none is stated.

    The registration's own uncertainty is not in it: readings of one session share that.
    """
    if reading.covariance_mm2 is None:
        return None
    turned = registration.rotation @ np.array(reading.covariance_mm2) @ registration.rotation.T
    # Rounding leaves it unsymmetric in the last digit; whoever factorises it later would stumble.
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (0.5 * (turned + turned.T)).tolist()
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)
