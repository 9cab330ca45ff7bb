from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.builders import make_identification, make_statistics
from truepose.domain.identification import NominalAndIdentified, Status
from truepose.identification import identify
from truepose.reports.identification.headline import headline
from truepose.reports.identification.judged_figures import judged
from truepose.reports.traceability import ReportConditions
from truepose.reports.uncertainty_budget import budget


def headline_of(identification, campaign):
    shown = judged(identification, campaign)
    return headline(identification, shown, budget(shown, identification, campaign, ReportConditions()))


def test_one_sentence_says_the_readings_both_uncertainties_and_noise(identification, campaign):
    made = headline_of(identification, campaign)

    assert made.good
    assert made.sentence.startswith("Assessed on 60 held-out positions. Expanded uncertainty")
    assert made.sentence.count("U = ") == 2
    assert (
        "Instrument noise and robot repeatability alone would give a mean error of 0.0160 mm" in made.sentence
    )  # sqrt(8/pi) * 0.01


@pytest.mark.parametrize("after_mm", [0.1, 0.2])
def test_a_model_that_errs_no_less_than_the_nominal_one_is_not_praised(campaign, identification, after_mm):
    worse = NominalAndIdentified(make_statistics(mean_mm=0.1), make_statistics(mean_mm=after_mm))

    made = headline_of(make_identification(validation=worse, model=identification.model), campaign)

    assert not made.good
    assert "The mean error does not fall." in made.sentence


def test_a_falling_mean_does_not_hide_a_growing_rms(campaign, identification):
    mixed = NominalAndIdentified(
        make_statistics(mean_mm=1.6, rms_mm=1.9), make_statistics(mean_mm=1.1, rms_mm=2.0)
    )

    made = headline_of(make_identification(validation=mixed, model=identification.model), campaign)

    assert not made.good
    assert "the RMS error does not fall (1.900 mm before, 2.000 mm after)" in made.sentence


def test_an_identification_that_did_not_converge_is_refused_first(campaign, identification):
    failed = make_identification(
        status=Status.NOT_CONVERGED, message="It did not settle.", model=identification.model
    )

    made = headline_of(failed, campaign)

    assert not made.good
    assert made.sentence.startswith("Do not use: It did not settle. ")


def test_without_a_model_the_message_is_the_headline():
    identification = make_identification(model=None, message="Only 3 configurations were measured.")

    made = headline(identification, None, None)

    assert (made.sentence, made.good) == ("Only 3 configurations were measured.", False)


def test_a_single_held_out_configuration_tells_no_uncertainty(identification, campaign):
    points = campaign.validation
    alone = replace(
        points,
        stops=points.stops.taken(np.array([0])),
        nest=points.nest[:1],
        position_mm=points.position_mm[:1],
        standard_uncertainty_mm=points.standard_uncertainty_mm[:1],
    )
    pair = NominalAndIdentified(make_statistics(n=1), make_statistics(n=1))

    made = headline_of(replace(identification, validation=pair), replace(campaign, validation=alone))

    assert made.sentence.startswith("Assessed on 1 held-out position.")
    assert made.sentence.count("U unknown from a single configuration") == 2


def test_noise_that_nobody_stated_is_no_noise_of_zero(identification, campaign):
    silent = NominalAndIdentified(make_statistics(noise_mm=0.0), make_statistics(noise_mm=0.0))

    made = headline_of(replace(identification, validation=silent), campaign)

    assert "The noise of instrument and robot is not stated" in made.sentence
    assert next(figure for figure in made.figures if figure.name == "Noise alone").remark == "not stated"


@pytest.mark.parametrize(
    ("held_out", "readings"), [(True, "60 held-out readings"), (False, "40 calibration readings")]
)
def test_the_noise_beside_the_figures_is_that_of_the_table_with_the_robots_scatter(
    campaign, held_out, readings
):
    restless = replace(campaign, robot=replace(campaign.robot, repeatability_mm=0.03))
    restless = restless if held_out else replace(restless, validation=None)
    identification = identify(restless, ("base", "geometry"))
    judging = identification.validation if held_out else identification.cross_validation

    made = headline_of(identification, restless)

    noise = next(figure for figure in made.figures if figure.name == "Noise alone")
    assert noise.value == f"{judging.identified.noise_mm:.4f} mm"
    assert judging.identified.noise_mm > 0.045  # the tracker alone would show 0.016 mm
    assert noise.value in made.sentence
    assert readings in noise.remark
