"""A ballbar sphere test as a document."""

from typing import Self

from pydantic import Field

from truepose.exchange.outgoing import Quantities, Quantity
from truepose.exchange.results.circles import ValueDocument
from truepose.exchange.results.document_base import Document, Spoken
from truepose.judgement.figure import Figure
from truepose.judgement.sphere.errors import SphereFigures
from truepose.judgement.sphere.judged import Sphere, SphereOfModel, SphereTest


class SphereFiguresDocument(Document):
    """Radial errors, measured less predicted; the columns of Tables 2.12 and 2.13 of the thesis, and more."""

    nest: int | None = Field(description="Null: of all nests.")
    n: int
    mean_mm: ValueDocument
    sd_mm: ValueDocument
    rms_mm: ValueDocument
    max_mm: ValueDocument = Field(description="The largest size.")
    config: int = Field(description="Configuration with the largest size.")
    range_mm: ValueDocument = Field(description="Largest less smallest.")

    @classmethod
    def of_figures(cls, nest: int | None, figures: SphereFigures, sphere: Sphere) -> Self:
        """Return the figures of a nest, or of all."""
        names = ("mean_mm", "sd_mm", "rms_mm", "max_mm", "range_mm")
        values = {name: ValueDocument.of_figure(getattr(figures, name)) for name in names}
        return cls(nest=nest, n=figures.n, config=int(sphere.config[figures.max_at]), **values)


class SphereErrorsDocument(Document):
    """Errors of one model about one centre."""

    model: str = Field(description="`nominal`, or the name that a model was given.")
    centre: str = Field(description="`taught`: where the arm held the ball; `best`: where the lengths fit.")
    centre_mm: Quantities = Field(description="In the world of the model.")
    noise_chance: Quantity = Field(description="That scatter alone shows errors as large.")
    noise_alone: bool
    figures: list[SphereFiguresDocument]
    error_mm: Quantities
    standard_uncertainty_mm: Quantities

    @classmethod
    def of_model(cls, one: SphereOfModel, sphere: Sphere) -> Self:
        """Return the errors of a model."""
        figures = [*one.by_nest, *([(None, one.whole)] if len(one.by_nest) > 1 else [])]
        return cls.of(
            one,
            one.errors,
            centre="best" if one.errors.centre.is_fitted else "taught",
            centre_mm=one.errors.centre.place_mm,
            noise_alone=one.is_noise,
            figures=[SphereFiguresDocument.of_figures(nest, own, sphere) for nest, own in figures],
            error_mm=one.errors.errors_mm,
        )


class SphereDocument(Document):
    """All lengths about one ball."""

    placement: int
    base_point: int
    config: list[int]
    nest: list[int]
    length_mm: Quantities
    shown_mm: Quantities | None = Field(description="Lengths less the bar's; null: nobody said which bar.")
    errors: list[SphereErrorsDocument]
    withheld: list[Spoken]

    @classmethod
    def of_sphere(cls, sphere: Sphere) -> Self:
        """Return a sphere."""
        errors = [SphereErrorsDocument.of_model(one, sphere) for one in sphere.models]
        config, nest = sphere.config.tolist(), sphere.nest.tolist()
        return cls.of(sphere, config=config, nest=nest, errors=errors)


class SphereRankDocument(Document):
    """RMS of all errors of a model."""

    model: str
    rms_mm: ValueDocument

    @classmethod
    def of_rank(cls, model: str, rms: Figure) -> Self:
        """Return a place in the order."""
        return cls(model=model, rms_mm=ValueDocument.of_figure(rms))


class SphereTestDocument(Document):
    """What `truepose sphere --json` prints, and `GET /sessions/{id}/sphere` shows."""

    robot: str
    nominal_mm: Quantity | None = Field(description="Length of the bar.")
    order: list[SphereRankDocument] = Field(description="Models, the most accurate first.")
    spheres: list[SphereDocument]
    skipped: int | None = Field(description="Stops that a person left out; null: nobody said.")


def sphere_document(test: SphereTest, robot: str) -> SphereTestDocument:
    """Return the spheres of a test, and the models in the order of their accuracy."""
    spheres = [SphereDocument.of_sphere(sphere) for sphere in test.spheres]
    order = [SphereRankDocument.of_rank(name, rms) for name, rms in test.order]
    return SphereTestDocument.of(test, robot=robot, spheres=spheres, order=order)
