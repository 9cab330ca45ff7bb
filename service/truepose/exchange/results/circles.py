"""A single-axis circle test as a document: angles in degrees."""

from typing import Self

import numpy as np
from pydantic import Field

from truepose.exchange.outgoing import Quantities, Quantity
from truepose.exchange.results.document_base import Document, Spoken
from truepose.judgement.circle.joint_curve import Wave
from truepose.judgement.circle.judged import CircleTest, JointCircle
from truepose.judgement.figure import Figure


class ValueDocument(Document):
    """A value with its standard uncertainty, in the unit of its name."""

    value: Quantity
    standard_uncertainty: Quantity

    @classmethod
    def of_figure(cls, figure: Figure) -> Self:
        """Return a figure that files state in its own unit."""
        return cls.of(figure)

    @classmethod
    def of_angle(cls, figure: Figure) -> Self:
        """Return an angle in degrees."""
        value, uncertainty = np.degrees([figure.value, figure.standard_uncertainty]).tolist()
        return cls(value=value, standard_uncertainty=uncertainty)


class JointWaveDocument(Document):
    """A wave of the angular error over the joint's angle: amplitude * cos(order * (angle - phase))."""

    order: int = Field(description="Periods a turn.")
    amplitude_deg: ValueDocument
    phase_deg: Quantity

    @classmethod
    def of_wave(cls, wave: Wave) -> Self:
        """Return a wave in degrees."""
        amplitude = ValueDocument.of_angle(wave.amplitude_rad)
        return cls(order=wave.order, amplitude_deg=amplitude, phase_deg=float(np.degrees(wave.phase_rad)))


class CircleStopsDocument(Document):
    """Errors at the stops, against the circle through the place at `zero_deg`."""

    config: list[int]
    angle_deg: Quantities
    direction: list[int] = Field(description="Sign of the joint's last motion, 0 unknown.")
    radial_mm: Quantities
    axial_mm: Quantities
    tangential_mm: Quantities
    tangential_uncertainty_mm: Quantities
    angular_deg: Quantities

    @classmethod
    def of_circle(cls, one: JointCircle) -> Self:
        """Return the errors of a sweep."""
        return cls.of(
            one.errors,
            config=one.config.tolist(),
            direction=one.direction.tolist(),
            angle_deg=np.degrees(one.errors.angle_rad),
            angular_deg=np.degrees(one.errors.angular_rad),
        )


class CircleDocument(Document):
    """What a sweep of one joint shows at one nest; the columns of Table 2.3 of the thesis, and more."""

    joint: int
    nest: int
    interval_deg: Quantities
    increment_deg: Quantity
    tangential_range_mm: ValueDocument
    angular_range_deg: ValueDocument
    backlash_deg: ValueDocument | None = Field(description="Null: no angle was visited from both sides.")
    radial_range_mm: Quantity
    axial_range_mm: Quantity
    radius_mm: Quantity
    zero_deg: Quantity
    noise_chance: Quantity = Field(description="That scatter alone shows errors as large.")
    noise_alone: bool
    gain: ValueDocument | None = Field(description="k1 - 1; null where the stops are too few.")
    waves: list[JointWaveDocument]
    left_deg: Quantity = Field(description="RMS of what neither gain, waves nor backlash follow.")
    set_aside: list[int] = Field(description="Configurations whose readings lie far off plane or circle.")
    stops: CircleStopsDocument

    @classmethod
    def of_circle(cls, one: JointCircle) -> Self:
        """Return a sweep in the units of files."""
        gap, gain = one.backlash_rad, one.curve.gain
        return cls.of(
            one,
            one.errors,
            one.curve,
            interval_deg=np.degrees(one.interval_rad),
            increment_deg=float(np.degrees(one.increment_rad)),
            tangential_range_mm=ValueDocument.of_figure(one.tangential_range_mm),
            angular_range_deg=ValueDocument.of_angle(one.angular_range_rad),
            backlash_deg=None if gap is None else ValueDocument.of_angle(gap),
            zero_deg=float(np.degrees(one.errors.zero_rad)),
            noise_alone=one.is_noise,
            gain=None if gain is None else ValueDocument.of_figure(gain),
            waves=[JointWaveDocument.of_wave(wave) for wave in one.curve.waves],
            left_deg=float(np.degrees(one.curve.left_rad)),
            set_aside=list(one.set_aside),
            stops=CircleStopsDocument.of_circle(one),
        )


class WithheldCircleDocument(Document):
    """A sweep that gives no circle, and why."""

    joint: int
    nest: int
    reason: Spoken


class CircleTestDocument(Document):
    """What `truepose circles --json` prints, and `GET /sessions/{id}/circles` shows."""

    robot: str
    circles: list[CircleDocument]
    withheld: list[WithheldCircleDocument]


def circle_document(test: CircleTest, robot: str) -> CircleTestDocument:
    """Return the circles of a test, and what is withheld."""
    circles = [CircleDocument.of_circle(one) for one in test.circles]
    return CircleTestDocument.of(test, robot=robot, circles=circles)
