"""The one sentence of a plant's pages: robots within their limits, failed, and what is missing."""

import pytest

from tests.unit.service.plant.test_calibration_due import day
from truepose.messages.catalogue import LANGUAGES, catalogue, english
from truepose.plant.outcome import Conformity, conformity, plant_outcome, robot_outcome
from truepose.storage.plant.overview import ResultFacts, RobotMeasured

MEANS = {"before_mm": 0.499, "after_mm": 0.0331, "quantity": "position"}
NUMBERS = {"identification": 1, "model": 2, "validation": 3, "diagnosis": 4}


def told(kind, ago=3, verdict="", figure_mm=None, limit_mm=None, **document):
    number = NUMBERS[kind]
    return ResultFacts(
        number, 1, "left arm", kind, number, "120-1", day(ago), verdict, figure_mm, limit_mm, document
    )


def validation(verdict="passed", figure_mm=0.0812, limit_mm=0.1, **more):
    return {"validation": told("validation", 3, verdict, figure_mm, limit_mm, **{**MEANS, **more})}


WITHOUT_LIMIT = validation("no_limit", 0.0331, 0.0301, promised=True)
ANSWERED = validation("failed", 0.412) | {"model": told("model", 1)}


@pytest.mark.parametrize(
    ("results", "how"),
    [
        (validation(), Conformity.WITHIN),
        (validation("failed", 0.412), Conformity.FAILED),
        (validation("undecided", 0.098), Conformity.UNDECIDED),
        (WITHOUT_LIMIT, Conformity.NO_LIMIT),
        (validation("worse", 0.412, 0.0301, promised=True), Conformity.NO_LIMIT),
        ({}, Conformity.NOT_VALIDATED),
        (ANSWERED, Conformity.NOT_VALIDATED),
        (validation() | {"model": told("model", 1)}, Conformity.NOT_VALIDATED),
    ],
)
def test_a_robot_stands_by_the_validation_of_its_newest_model(results, how):
    assert conformity(results) is how


BOTH = "Mean error 0.499 mm before (nominal), 0.0331 mm after; "


@pytest.mark.parametrize(
    ("results", "said"),
    [
        (validation(), f"{BOTH}largest 0.0812 mm, limit 0.1 mm: pass."),
        (validation("failed", 0.412), f"{BOTH}largest 0.412 mm, limit 0.1 mm: fail."),
        (WITHOUT_LIMIT, f"{BOTH}no limit set: set a limit to get a pass or fail."),
        (
            ANSWERED | {"identification": told("identification", 1, "converged", 0.0331, **MEANS)},
            f"{BOTH}no limit set: validate to get a pass or fail.",
        ),
        (
            {"diagnosis": told("diagnosis", 1, "explained", 0.0331, before_mm=None)},
            "Mean error not recorded before (nominal), 0.0331 mm after; no limit set: validate to get ",
        ),
        (
            {"validation": told("validation", 3, "failed", 0.412, 0.3)},  # means were not kept
            "Largest 0.412 mm, limit 0.3 mm: fail.",
        ),
        ({}, "No error has been measured, neither before nor after: "),
    ],
)
def test_a_robot_begins_with_its_errors_its_limit_and_pass_or_fail(results, said):
    assert english(robot_outcome(results)).startswith(said)


def robots(**cells):
    """Return a robot of each cell, with what was told of it."""
    measured = [RobotMeasured(f"R-{cell}", "IRB 120", day(3), cell) for cell in cells]
    return measured, {f"R-{cell}": results for cell, results in cells.items()}


def said(names, **cells):
    return english(plant_outcome(names, *robots(**cells)))


def test_a_plant_passes_where_every_cell_has_a_robot_within_its_limit():
    assert (
        said("ab", a=validation(), b=validation()) == "Robot within its limit in 2 of 2 cells; overall: pass."
    )


def test_what_failed_is_said_with_the_worst_and_what_is_missing_beside_it():
    cells = {
        "a": validation(),
        "b": validation("failed", 0.412, 0.3),
        "c": validation("failed", 0.3, 0.1),
        "d": WITHOUT_LIMIT,
        "e": ANSWERED,
        "f": validation("undecided", 0.098),
    }

    assert said("abcdefg", **cells) == (
        "Robot within its limit in 1 of 7 cells; failed in 2 (worst: R-c in c, largest error 0.300 mm, "
        "limit 0.1 mm); cannot be decided in 1; no limit set in 1; not validated in 2; overall: fail."
    )


def test_where_nothing_failed_what_is_missing_ends_the_sentence():
    assert said("ab", a=validation()) == (
        "Robot within its limit in 1 of 2 cells; not validated in 1; overall: validate with a limit to get a "
        "pass or fail."
    )
    assert said("a", a=WITHOUT_LIMIT).startswith(
        "Robot within its limit in 0 of 1 cells; no limit set in 1; overall: "
    )
    assert said("") == "No cell belongs to this plant yet, so nothing can pass or fail."


def test_a_cell_stands_as_its_worst_robot_and_robots_elsewhere_are_not_counted():
    measured = [
        RobotMeasured(name, "IRB 120", day(3), cell) for name, cell in (("1", "a"), ("2", "a"), ("3", "z"))
    ]
    results = {"1": validation(), "2": validation("failed", None), "3": validation("failed", 9.0)}

    assert english(plant_outcome(["a"], measured, results)) == (
        "Robot within its limit in 0 of 1 cells; failed in 1 (worst: 2 in a, its error is not a finite "
        "number); overall: fail."
    )


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_says_the_worst_in_the_units_of_its_reader(language):
    words = catalogue(f"{language}-x-inch")

    spoken = words.spoken(plant_outcome("ab", *robots(a=validation("failed", 0.412), b=validation())))

    assert f"0{words.units.decimal}01622 in" in spoken
    assert "mm" not in spoken
