"""A ballbar sphere test in sentences and as the tables of the thesis."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

from rich.table import Table

from truepose.domain.sentences import Sentence, said
from truepose.judgement.figure import Figure
from truepose.judgement.sphere.errors import SphereFigures
from truepose.judgement.sphere.judged import NOMINAL, Sphere, SphereOfModel, SphereTest
from truepose.reports.wording.rounding import rounded
from truepose.words.catalogue import Catalogue

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
WORDS_OF_ROW: Final = 4  # cells of a row that are names


def sphere_heads(words: Catalogue) -> list[str]:
    """Return what stands above the columns of `sphere_rows`."""
    return [words.say(head) for head in _HEADS]


def sphere_rows(test: SphereTest, words: Catalogue) -> Iterator[tuple[str, ...]]:
    """Yield a row per ball, nest, model and centre, as Table 2.12 (thesis of A. Nubiola, 2014)."""
    for sphere in test.spheres:
        for nest in sphere.nests:
            for one in sphere.models:
                yield _row(sphere, one, nest, dict(one.by_nest)[nest], words)


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
        *(rounded(number.value, number.standard_uncertainty, "mm") for number in numbers),
    )


def model_name(model: str, words: Catalogue) -> str:
    """Return what a model is called: the nominal one by its word, others as somebody named them."""
    return words.say("sphere.nominal") if model == NOMINAL else model


def sphere_table(test: SphereTest, words: Catalogue) -> Table:
    """Return the rows as a table of a terminal."""
    table = Table(padding=0)  # nine columns on a narrow terminal
    for k, head in enumerate(sphere_heads(words)):
        table.add_column(head.replace(", ", ",\n"), justify="left" if k in {2, 3} else "right")
    for row in sphere_rows(test, words):
        table.add_row(*row)
    return table


def sphere_test_sentences(test: SphereTest, words: Catalogue) -> Iterator[Sentence]:
    """Yield what the spheres say of the models, and which errors are withheld."""
    yield from order_sentences(test, words)
    for sphere in test.spheres:
        for sentence in sphere_sentences(sphere, words):
            yield said(
                "sphere.of_ball",
                placement=sphere.placement,
                base_point=sphere.base_point,
                sentence=sentence,
            )
    yield said("sphere.within")


def order_sentences(test: SphereTest, words: Catalogue) -> Iterator[Sentence]:
    """Yield the models in the order of their accuracy, which are not told apart, and what was left out."""
    if test.skipped:
        yield said("sphere.skipped_one" if test.skipped == 1 else "sphere.skipped", stops=test.skipped)
    if len(test.order) < 2:
        return
    yield said("sphere.order", models=tuple(_ranked(name, rms, words) for name, rms in test.order))
    for (first, least), (second, more) in pairwise(test.order):
        difference = more.value - least.value
        if difference < 2.0 * (least.standard_uncertainty**2 + more.standard_uncertainty**2) ** 0.5:
            yield said("sphere.alike", first=model_name(first, words), second=model_name(second, words))


def _ranked(name: str, rms: Figure, words: Catalogue) -> Sentence:
    u = rms.standard_uncertainty
    return said("sphere.ranked", model=model_name(name, words), rms_mm=rms.value, u_mm=u)


def sphere_sentences(sphere: Sphere, words: Catalogue) -> Iterator[Sentence]:
    """Yield what the lengths about one ball say of each model."""
    for one in sphere.models:
        yield _of_model(one, sphere, words)
    yield from sphere.withheld


def _of_model(one: SphereOfModel, sphere: Sphere, words: Catalogue) -> Sentence:
    largest = one.whole.max_mm
    return said(
        _ABOUT[one.is_noise, one.errors.centre.is_fitted],
        model=model_name(one.model, words),
        max_mm=largest.value,
        u_mm=largest.standard_uncertainty,
        config=int(sphere.config[one.whole.max_at]),
    )
