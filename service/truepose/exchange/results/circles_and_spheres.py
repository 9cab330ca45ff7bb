"""A single-axis circle test and a ballbar sphere test as documents: angles in degrees."""

from typing import Annotated, Self

import numpy as np
from pydantic import Field

from truepose.exchange.results.document import (
    Document,
    FieldSource,
    Integers,
    Quantities,
    Quantity,
    Spoken,
    in_degrees,
)
from truepose.validation.circle_test import CircleTest
from truepose.validation.sphere_errors import SphereFigures
from truepose.validation.sphere_test import Sphere, SphereOfModel, SphereTest
from truepose.validation.uncertainty import Figure


class ValueDocument(Document):
    """A value with its standard uncertainty, in the unit of its name."""

    value: Quantity
    standard_uncertainty: Quantity


def _figure_in_degrees(path: str) -> FieldSource:
    return FieldSource(path, lambda it: Figure(*np.degrees([it.value, it.standard_uncertainty]).tolist()))


class JointWaveDocument(Document):
    """Periodic part of the angular error over the joint angle: amplitude * cos(order * (angle - phase))."""

    order: int = Field(description="Number of periods per turn.")
    amplitude_deg: Annotated[ValueDocument, _figure_in_degrees("amplitude_rad")]
    phase_deg: Annotated[Quantity, in_degrees("phase_rad")]


class CircleStopsDocument(Document):
    """Errors at each configuration, relative to the circle through the position at `zero_deg`."""

    config: Integers
    angle_deg: Annotated[Quantities, in_degrees("errors.angle_rad")]
    direction: Integers = Field(description="Direction of the joint's last motion: 1, -1, or 0 if unknown.")
    radial_mm: Annotated[Quantities, FieldSource("errors.radial_mm")]
    axial_mm: Annotated[Quantities, FieldSource("errors.axial_mm")]
    tangential_mm: Annotated[Quantities, FieldSource("errors.tangential_mm")]
    tangential_uncertainty_mm: Annotated[Quantities, FieldSource("errors.tangential_uncertainty_mm")]
    angular_deg: Annotated[Quantities, in_degrees("errors.angular_rad")]


class CircleDocument(Document):
    """Results of one joint sweep measured at one nest, including the columns of Table 2.3 of the thesis."""

    joint: int
    nest: int
    interval_deg: Annotated[Quantities, in_degrees("interval_rad")]
    increment_deg: Annotated[Quantity, in_degrees("increment_rad")]
    tangential_range_mm: ValueDocument
    angular_range_deg: Annotated[ValueDocument, _figure_in_degrees("angular_range_rad")]
    backlash_deg: Annotated[ValueDocument | None, _figure_in_degrees("backlash_rad")] = Field(
        description="Backlash of the joint; null if no angle was approached from both sides."
    )
    radial_range_mm: Quantity
    axial_range_mm: Quantity
    radius_mm: Annotated[Quantity, FieldSource("errors.radius_mm")]
    zero_deg: Annotated[Quantity, in_degrees("errors.zero_rad")]
    noise_chance: Annotated[Quantity, FieldSource("curve.noise_chance")] = Field(
        description="Probability that scatter alone causes errors this large."
    )
    noise_alone: Annotated[bool, FieldSource("is_noise")]
    gain: Annotated[ValueDocument | None, FieldSource("curve.gain")] = Field(
        description="Gain error k1 - 1; null if there are too few configurations."
    )
    waves: Annotated[list[JointWaveDocument], FieldSource("curve.waves")]
    left_deg: Annotated[Quantity, in_degrees("curve.left_rad")] = Field(
        description="RMS of the residual not explained by gain, periodic errors or backlash."
    )
    set_aside: list[int] = Field(
        description="Configurations excluded because their readings lie far off the plane or circle."
    )
    stops: Annotated[CircleStopsDocument, FieldSource("")]


class WithheldCircleDocument(Document):
    """A sweep for which no circle could be computed, with the reason."""

    joint: int
    nest: int
    reason: Spoken


class CircleTestDocument(Document):
    """Result of `truepose circles --json` and of `GET /sessions/{id}/circles`."""

    robot: str
    circles: list[CircleDocument]
    withheld: list[WithheldCircleDocument]


def circle_document(test: CircleTest, robot: str) -> CircleTestDocument:
    """Return the circles of a test, and what is withheld."""
    return CircleTestDocument.of(test, robot=robot)


class SphereFiguresDocument(Document):
    """Radial errors, measured minus predicted, with the columns of Tables 2.12 and 2.13 of the thesis."""

    nest: int | None = Field(description="Tool nest; null for all nests together.")
    n: int
    mean_mm: ValueDocument
    sd_mm: ValueDocument
    rms_mm: ValueDocument
    max_mm: ValueDocument = Field(description="Largest absolute error.")
    config: int = Field(description="Configuration with the largest absolute error.")
    range_mm: ValueDocument = Field(description="Largest minus smallest error.")

    @classmethod
    def of_figures(cls, nest: int | None, figures: SphereFigures, sphere: Sphere) -> Self:
        """Return the figures of a nest, or of all."""
        return cls.of(figures, nest=nest, config=int(sphere.config[figures.max_at]))


class SphereErrorsDocument(Document):
    """Radial errors of one model about one centre."""

    model: str = Field(description="`nominal`, or the name given to the model.")
    centre: Annotated[str, FieldSource("errors.centre.is_fitted", ("taught", "best").__getitem__)] = Field(
        description="`taught`: centre where the arm held the ball; `best`: centre that fits the lengths best."
    )
    centre_mm: Annotated[Quantities, FieldSource("errors.centre.place_mm")] = Field(
        description="Centre of the sphere in the world frame of the model."
    )
    noise_chance: Annotated[Quantity, FieldSource("errors.noise_chance")] = Field(
        description="Probability that scatter alone causes errors this large."
    )
    noise_alone: Annotated[bool, FieldSource("is_noise")]
    figures: list[SphereFiguresDocument]
    error_mm: Annotated[Quantities, FieldSource("errors.errors_mm")]
    standard_uncertainty_mm: Annotated[Quantities, FieldSource("errors.standard_uncertainty_mm")]

    @classmethod
    def of_model(cls, one: SphereOfModel, sphere: Sphere) -> Self:
        """Return the errors of a model."""
        figures = [*one.by_nest, *([(None, one.whole)] if len(one.by_nest) > 1 else [])]
        return cls.of(one, figures=[SphereFiguresDocument.of_figures(*own, sphere) for own in figures])


class SphereDocument(Document):
    """All lengths measured to one ball."""

    placement: int
    base_point: int
    config: Integers
    nest: Integers
    length_mm: Quantities
    shown_mm: Quantities | None = Field(
        description="Measured lengths minus the nominal bar length; null if the bar is unknown."
    )
    errors: list[SphereErrorsDocument]
    withheld: list[Spoken]

    @classmethod
    def of_sphere(cls, sphere: Sphere) -> Self:
        """Return a sphere."""
        return cls.of(sphere, errors=[SphereErrorsDocument.of_model(one, sphere) for one in sphere.models])


class SphereRankDocument(Document):
    """RMS error of one model over all spheres."""

    model: str
    rms_mm: ValueDocument


class SphereTestDocument(Document):
    """Result of `truepose sphere --json` and of `GET /sessions/{id}/sphere`."""

    robot: str
    nominal_mm: Quantity | None = Field(description="Nominal length of the bar.")
    order: list[SphereRankDocument] = Field(description="Models, most accurate first.")
    spheres: list[SphereDocument]
    skipped: int | None = Field(
        description="Number of configurations skipped by the operator; null if not known."
    )


def sphere_document(test: SphereTest, robot: str) -> SphereTestDocument:
    """Return the spheres of a test, and the models in the order of their accuracy."""
    spheres = [SphereDocument.of_sphere(sphere) for sphere in test.spheres]
    order = [SphereRankDocument.of(model=model, rms_mm=rms) for model, rms in test.order]
    return SphereTestDocument.of(test, robot=robot, spheres=spheres, order=order)
