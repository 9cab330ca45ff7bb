"""A ballbar sphere test: its report, its table as in the thesis, its sentences and its figures."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, message, together
from truepose.reports.cover_page import Front
from truepose.reports.limits import NO_LIMIT, FigureNames, Limit, LimitedTest
from truepose.reports.report import Description, Report
from truepose.reports.rounding import format_rounded
from truepose.reports.tables import Table, heads_of
from truepose.validation.sphere_errors import SphereFigures
from truepose.validation.sphere_test import NOMINAL, Sphere, SphereOfModel, SphereTest
from truepose.validation.uncertainty import Figure

_HEADS: Final = (
    "sphere.head.ball",
    "sphere.head.nest",
    "sphere.head.model",
    "sphere.head.centre",
    "sphere.head.lengths",
    "sphere.head.mean",
    "sphere.head.sd",
    "sphere.head.max",
    "sphere.head.range",
)
_ABOUT: Final = {  # whether they are noise, and about a centre that was fitted
    (True, True): "sphere.noise_about_best",
    (True, False): "sphere.noise_about_taught",
    (False, True): "sphere.errors_about_best",
    (False, False): "sphere.errors_about_taught",
}
_NAMES: Final = FigureNames("front.sphere", "front.sphere.largest", "front.sphere.bars")


@dataclass(frozen=True, slots=True)
class SphereReport(Report):
    """The lengths about each ball by each model; the one that commands the arm is held against the limit."""

    test: SphereTest
    robot: str
    limit: Limit = NO_LIMIT
    commanded_by: str | None = None  # None: the most accurate

    def described(self, words: Catalogue) -> Description:
        """Return the table, and each ball with its figure and its sentences."""
        from truepose.reports.figures.bands import radial_figure  # the drawing library is slow to import

        def called(model: str) -> str:
            return model_name(model, words)

        spheres = [
            (
                sphere,
                radial_figure(sphere, called, words) if sphere.models else None,
                [words.spoken(sentence) for sentence in sphere_sentences(sphere, words)],
            )
            for sphere in self.test.spheres
        ]
        shown = {
            "table": sphere_table(self.test, words),
            "order": [words.spoken(sentence) for sentence in order_sentences(self.test, words)],
            "spheres": spheres,
        }
        best = self.test.order[0][0] if self.test.order else NOMINAL
        front = sphere_front(self.test, self.robot, self.commanded_by or best, self.limit, words)
        return Description(
            words.say("sphere.title", robot=self.robot), self.robot, "spheres.html", shown, front
        )


def sphere_front(test: SphereTest, robot: str, model: str, limit: Limit, words: Catalogue) -> Front:
    """Return whether the radial errors of a model stay within a limit.

    They are about the taught centre, which is how the arm is used; about the best one where none was taught.
    """
    found = [(ball, ball.of(model, taught=True) or ball.of(model, taught=False)) for ball in test.spheres]
    named = [(_ball(ball, words), one.whole.max_mm) for ball, one in found if one is not None]
    missing = dict.fromkeys(why for ball, one in found if one is None for why in ball.withheld)
    skipped = _skipped(test.skipped) if test.skipped else ""
    title = words.say("front.sphere.title", robot=robot, model=model_name(model, words))
    return LimitedTest(title, robot, _NAMES, named, together(skipped, *missing)).front(limit, words)


def _skipped(stops: int) -> Message:
    return message("sphere.skipped_one" if stops == 1 else "sphere.skipped", stops=stops)


def _ball(ball: Sphere, words: Catalogue) -> str:
    return words.say("front.of_ball", placement=ball.placement, base_point=ball.base_point)


def sphere_table(test: SphereTest, words: Catalogue) -> Table:
    """Return a row per ball, nest, model and centre, as Table 2.12 (thesis of A. Nubiola, 2014)."""
    rows = [
        _row(sphere, one, nest, dict(one.by_nest)[nest], words)
        for sphere in test.spheres
        for nest in sphere.nests
        for one in sphere.models
    ]
    return Table(heads_of(words, *_HEADS), rows, names=4)


def _row(
    sphere: Sphere, one: SphereOfModel, nest: int, figures: SphereFigures, words: Catalogue
) -> tuple[str, ...]:
    numbers = (figures.mean_mm, figures.sd_mm, figures.max_mm, figures.range_mm)
    centre = "sphere.best" if one.errors.centre.is_fitted else "sphere.taught"
    return (
        f"{sphere.placement}.{sphere.base_point}",
        str(nest),
        model_name(one.model, words),
        words.say(centre),
        str(figures.n),
        *(format_rounded(number.value, number.standard_uncertainty, "mm") for number in numbers),
    )


def model_name(model: str, words: Catalogue) -> str:
    """Return what a model is called: the nominal one by its word, others as somebody named them."""
    return words.say("sphere.nominal") if model == NOMINAL else model


def sphere_test_sentences(test: SphereTest, words: Catalogue) -> Iterator[Message]:
    """Yield what the spheres say of the models, and which errors are withheld."""
    yield from order_sentences(test, words)
    for sphere in test.spheres:
        for sentence in sphere_sentences(sphere, words):
            yield message(
                "sphere.of_ball",
                placement=sphere.placement,
                base_point=sphere.base_point,
                sentence=sentence,
            )
    yield message("sphere.within")


def order_sentences(test: SphereTest, words: Catalogue) -> Iterator[Message]:
    """Yield the models in the order of their accuracy, which are not told apart, and what was left out."""
    if test.skipped:
        yield _skipped(test.skipped)
    if len(test.order) < 2:
        return
    yield message("sphere.order", models=tuple(_ranked(name, rms, words) for name, rms in test.order))
    for (first, least), (second, more) in pairwise(test.order):
        difference = more.value - least.value
        if difference < 2.0 * (least.standard_uncertainty**2 + more.standard_uncertainty**2) ** 0.5:
            yield message("sphere.alike", first=model_name(first, words), second=model_name(second, words))


def _ranked(name: str, rms: Figure, words: Catalogue) -> Message:
    u = rms.standard_uncertainty
    return message("sphere.ranked", model=model_name(name, words), rms_mm=rms.value, u_mm=u)


def sphere_sentences(sphere: Sphere, words: Catalogue) -> Iterator[Message]:
    """Yield what the lengths about one ball say of each model."""
    for one in sphere.models:
        yield _of_model(one, sphere, words)
    yield from sphere.withheld


def _of_model(one: SphereOfModel, sphere: Sphere, words: Catalogue) -> Message:
    largest = one.whole.max_mm
    return message(
        _ABOUT[one.is_noise, one.errors.centre.is_fitted],
        model=model_name(one.model, words),
        max_mm=largest.value,
        u_mm=largest.standard_uncertainty,
        config=int(sphere.config[one.whole.max_at]),
    )
