"""What one campaign tells of its robot, computed on a worker and kept as a file."""

from dataclasses import dataclass
from datetime import date

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.campaign import Campaign
from truepose.domain.results.identification import Unit
from truepose.domain.robot import Robot
from truepose.effects.ports import ParameterSpec
from truepose.exchange.tables.visits import Stated
from truepose.fleet.information import Information
from truepose.storage.columns import pack, unpack


@dataclass(frozen=True, slots=True)
class Told:
    """What a campaign tells of P parameters, and whose it says that it is."""

    robot: Robot  # nominal
    robot_serial_number: str
    instrument_serial_number: str
    measured_on: str
    simulated: bool
    names: tuple[str, ...]  # (P,)
    units: tuple[Unit, ...]
    means: FloatArray  # (P,) as stated beforehand
    widths: FloatArray
    owners: tuple[str, ...]
    normal: FloatArray  # (P, P)
    right: FloatArray  # (P,)
    motion_mm2: FloatArray  # (P, P)
    readings: int
    temperature_c: float | None = None

    @property
    def information(self) -> Information:
        """As a fleet takes it."""
        stated = zip(self.names, self.units, self.means.tolist(), self.widths.tolist(), strict=True)
        specs = tuple(ParameterSpec(*one) for one in stated)
        return Information(
            specs,
            self.owners,
            self.normal,
            self.right,
            self.motion_mm2,
            self.readings,
            self.temperature_c,
        )

    @property
    def stated(self) -> Stated:
        """What the campaign itself says of its readings."""
        day = date.fromisoformat(self.measured_on) if self.measured_on else None
        return Stated(self.robot_serial_number, self.instrument_serial_number, day)


def told_of(campaign: Campaign, told: Information) -> Told:
    """Return what a campaign tells, with what it says of itself."""
    return Told(
        robot=campaign.robot,
        robot_serial_number=campaign.robot_serial_number,
        instrument_serial_number=campaign.instrument_serial_number,
        measured_on="" if campaign.measured_on is None else campaign.measured_on.isoformat(),
        simulated=bool(campaign.simulated),
        names=told.names,
        units=tuple(spec.unit for spec in told.specs),
        means=np.array([spec.prior_mean for spec in told.specs]),
        widths=np.array([spec.prior_width for spec in told.specs]),
        owners=told.owners,
        normal=told.normal,
        right=told.right,
        motion_mm2=told.motion_mm2,
        readings=told.readings,
        temperature_c=told.temperature_c,
    )


def tell(content: bytes, _seed: np.random.SeedSequence) -> bytes:
    """Return what a campaign as it is stored tells, packed; nothing of it is drawn by chance.

    Raises TrueposeError.
    """
    from truepose.analysis.workers.tasks import stored_campaign
    from truepose.fleet.information import information_of

    campaign = stored_campaign(content)
    return pack(told_of(campaign, information_of(campaign)))


def told_from(data: bytes) -> Told:
    """Read what `tell` returned; raises DamagedDatabaseError."""
    return unpack(Told, data)
