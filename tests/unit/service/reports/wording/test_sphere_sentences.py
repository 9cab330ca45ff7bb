"""What a sphere test says: models in their order, those that lengths do not tell apart, what is withheld."""

from dataclasses import replace

import pytest

from tests.helpers.ballbar.spheres import knowing, longer, sphere_campaign
from truepose.exchange.results.circles_and_spheres import sphere_document
from truepose.messages.catalogue import IN_ENGLISH, catalogue, english
from truepose.reports.spheres import order_sentences, sphere_table, sphere_test_sentences
from truepose.validation.sphere_test import sphere_test


def test_models_that_the_lengths_do_not_tell_apart_are_named():
    campaign = sphere_campaign(longer(), noise=1.0, per_nest=15)

    test = sphere_test(campaign, {"first": knowing(0.2), "second": knowing(0.201), "third": knowing(0.1)})

    said = [english(sentence) for sentence in order_sentences(test, IN_ENGLISH)]
    assert said[0].startswith("Accuracy, best first: ")
    (alike,) = said[1:]
    assert {"first", "second"} == set(
        alike.removeprefix("The lengths do not distinguish ").removesuffix(".").split(" from ")
    )


def test_one_model_has_no_order():
    assert list(order_sentences(sphere_test(sphere_campaign(per_nest=8)), IN_ENGLISH)) == []


@pytest.mark.parametrize(
    ("skipped", "said_first"),
    [(3, "3 configurations were"), (1, "One configuration was"), (0, None), (None, None)],
)
def test_stops_that_a_person_left_out_are_counted(skipped, said_first):
    """Who skips what the bar does not reach leaves out the largest errors."""
    test = replace(sphere_test(sphere_campaign(per_nest=8)), skipped=skipped)

    said = [english(sentence).split(" skipped")[0] for sentence in order_sentences(test, IN_ENGLISH)]

    assert said == ([said_first] if said_first else [])
    assert sphere_document(test, "arm").skipped == skipped


def test_what_is_withheld_is_said_with_its_ball_and_has_no_row():
    test = sphere_test(sphere_campaign(per_nest=4, nests=(1,)))

    assert list(sphere_table(test, IN_ENGLISH).rows) == []
    said = [english(sentence) for sentence in sphere_test_sentences(test, IN_ENGLISH)]
    assert said[0] == "Placement 1, base point 1: Lengths to this ball: 4. Six are needed."


def test_the_nominal_arm_has_its_word_in_every_language():
    test = sphere_test(sphere_campaign(per_nest=8), {"laser": knowing(0.0)})

    rows = list(sphere_table(test, catalogue("fr")).rows)

    assert {row[2] for row in rows} == {"nominal", "laser"}
    assert {row[3] for row in rows} == {"appris", "meilleur"}
