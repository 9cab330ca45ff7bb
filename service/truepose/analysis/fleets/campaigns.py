"""What one campaign tells of its robot, computed on a worker and kept as a file; which can be compared."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import date

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign
from truepose.domain.identification import Unit
from truepose.domain.robot import Robot
from truepose.effects.ports import ParameterSpec
from truepose.exchange.tables.files import Stated
from truepose.fleet.campaigns import Information
from truepose.fleet.outlying_campaigns import OutlyingCampaign
from truepose.storage.documents import pack, unpack


@dataclass(frozen=True, slots=True)
class CampaignEstimate:
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


def summarise(campaign: Campaign, told: Information) -> CampaignEstimate:
    """Return what a campaign tells, with what it says of itself."""
    return CampaignEstimate(
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
    from truepose.analysis.job_queue.tasks import stored_campaign
    from truepose.fleet.campaigns import information_of

    campaign = stored_campaign(content)
    return pack(summarise(campaign, information_of(campaign)))


def summary_from(data: bytes) -> CampaignEstimate:
    """Read what `tell` returned; raises DamagedDatabaseError."""
    return unpack(CampaignEstimate, data)


@dataclass(frozen=True, slots=True)
class Entry:
    """A campaign as a fleet takes it."""

    campaign: str
    stated: Stated
    told: CampaignEstimate


def unfit_of(entries: Sequence[Entry]) -> Iterator[tuple[Entry, str]]:
    """Yield the campaigns of one type that cannot be compared, each with the sentence that says why."""
    usual = Counter(one.told.robot.joints for one in entries).most_common(1)
    before: dict[bytes, str] = {}
    for one in entries:
        # By what they say of the parameters: the same readings in two files, or in two formats, are one
        # measurement.
        readings = one.told.right.tobytes() + one.told.normal.tobytes()
        if why := _lacking(one.stated):
            yield one, why
        elif one.told.robot.joints != usual[0][0]:
            yield one, _OTHER_TABLE
        elif readings in before:
            yield one, f"It has the same readings as {before[readings]}; they are counted once."
        else:
            before[readings] = one.campaign


_OTHER_TABLE = (
    "Its nominal robot table differs from that of most campaigns of this type, and parameters are relative "
    "to that table. Give this campaign the same table as the others, or a type of its own."
)


def unlike_sentence(one: OutlyingCampaign) -> str:
    """Return in a sentence why a campaign is not compared with the others of its robot."""
    day = date.fromordinal(int(one.day)).isoformat()
    other = f"It matches {one.resembles}" if one.resembles else "It matches no other robot in the fleet"
    return (
        f"The campaign of {day} does not match the other campaigns of {one.robot}. {other}. Check which "
        "robot, tool and nests were measured; if all are correct, measure again."
    )


def _lacking(stated: Stated) -> str:
    """Return in a sentence what nobody says of a campaign; empty: all is said."""
    known = {
        "robot_serial_number": stated.robot,
        "instrument_serial_number": stated.instrument,
        "measured_on": stated.day,
    }
    lacking = [name for name, value in known.items() if not value]
    if not lacking:
        return ""
    return f"Not stated: {', '.join(lacking)}. Add it to its campaign.json, or give a table."
