from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.builders import make_pair
from truepose.domain.identification import NominalAndIdentified
from truepose.identification.model.estimates import identified_estimate, nominal_estimate
from truepose.identification.verdict.judge import judge_estimates, statistics
from truepose.messages.catalogue import english
from truepose.reports.identification.judged_figures import judged
from truepose.reports.traceability import ReportConditions
from truepose.reports.uncertainty_budget import DRAWS, budget, motion_shifts, spread_of_mean_mm

# A standard deviation from N draws scatters by 1 / sqrt(2 N) of itself; four times is ample.
MONTE_CARLO = 4.0 / np.sqrt(2.0 * DRAWS)


@pytest.fixture
def shown(identification, campaign):
    return judged(identification, campaign)


def rows_of(shown, identification, campaign, **conditions):
    made = budget(shown, identification, campaign, ReportConditions(**conditions))
    return made, {english(row.source): row for row in made.contributions}


def test_one_reading_per_configuration_gives_the_usual_standard_error(shown, identification, campaign):
    _, rows = rows_of(shown, identification, campaign)

    norms = np.linalg.norm(shown.identified_mm, axis=1)
    expected = norms.std(ddof=1) / np.sqrt(len(norms))
    assert rows["Finite number of configurations"].after_mm == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("as_revisits", [False, True])
def test_reading_every_configuration_twice_buys_no_certainty(shown, identification, campaign, as_revisits):
    doubled = read_twice(shown, identification.model, as_revisits)
    # The scatter of the doubled errors, so that only their number could change the figure.
    pair = NominalAndIdentified(statistics(doubled.nominal_mm, 0.0), statistics(doubled.identified_mm, 0.0))

    _, once = rows_of(shown, identification, campaign)
    _, again = rows_of(doubled, replace(identification, validation=pair), campaign)

    source = "Finite number of configurations"
    assert english(again[source].stated) == "60 configurations"
    assert again[source].after_mm == pytest.approx(once[source].after_mm, rel=1e-12)


def read_twice(shown, model, as_revisits):
    block = shown.block.taken(np.tile(np.arange(60), 2))
    if as_revisits:
        first = shown.stops.config
        stops = replace(
            block.targets.stops,
            config=np.concatenate([first, first + 1000]),
            repeat_of=np.concatenate([np.full(60, -1), first]),
        )
        block = replace(block, targets=replace(block.targets, stops=stops))
    return judge_estimates(block, nominal_estimate(model), identified_estimate(model))


def test_cross_validated_errors_count_with_their_own_scatter(identification, campaign_without_validation):
    plain = judged(identification, campaign_without_validation)
    sd = float(np.linalg.norm(plain.identified_mm, axis=1).std(ddof=1))
    crossed = make_pair(sd_mm=2.0 * sd)
    judging = replace(identification, validation=None, cross_validation=crossed)

    _, rows = rows_of(plain, judging, campaign_without_validation)

    expected = 2.0 * sd / np.sqrt(40.0)
    assert rows["Finite number of configurations"].after_mm == pytest.approx(expected, rel=1e-12)


def test_a_shift_along_all_errors_moves_their_mean_by_itself():
    residual = np.tile([5.0, 0.0, 0.0], (20, 1))
    shift = np.tile([0.01, 0.0, 0.0], (1, 20, 1))

    assert spread_of_mean_mm(residual, shift) == pytest.approx(0.01, rel=MONTE_CARLO)


def test_a_shift_across_all_errors_hardly_moves_their_mean():
    residual = np.tile([5.0, 0.0, 0.0], (20, 1))
    shift = np.tile([0.0, 0.01, 0.0], (1, 20, 1))

    # Second order: the norm grows by s^2 / (2 * 5 mm), of which sqrt(2) * 1e-5 mm is spread.
    assert spread_of_mean_mm(residual, shift) == pytest.approx(np.sqrt(2.0) * 1e-5, rel=0.25)


def test_motions_of_the_world_have_the_covariance_they_are_drawn_from(shown):
    covariance = np.diag([1e-4, 4e-4, 9e-4, 1e-8, 2e-8, 3e-8])
    covariance[0, 4] = covariance[4, 0] = 5e-7

    shifts = motion_shifts(shown, covariance)

    point = shown.position_mm[0]
    jacobian = np.hstack([np.eye(3), np.array([np.cross(axis, point) for axis in np.eye(3)]).T])
    carried = np.einsum("kd,ke->de", shifts[:, 0], shifts[:, 0])
    assert carried == pytest.approx(jacobian @ covariance @ jacobian.T, rel=1e-9, abs=1e-15)


def test_the_combination_is_the_root_of_the_sum_of_squares(shown, identification, campaign):
    made, rows = rows_of(shown, identification, campaign, temperature_c=(20.0, 24.0))

    parts = [row.after_mm for row in rows.values() if row.after_mm is not None]
    assert len(parts) == 5  # sampling, parameters, nests, registration, temperature
    assert made.after_mm == pytest.approx(np.sqrt(np.sum(np.square(parts))), rel=1e-12)


def test_better_known_parameters_count_less(shown, identification, campaign):
    sharper = replace(identification.model, covariance=identification.model.covariance / 100.0)

    _, rows = rows_of(shown, identification, campaign)
    _, sharp = rows_of(shown, replace(identification, model=sharper), campaign)

    source = "Identified parameters"
    # Ten times smaller to first order; second order only helps.
    assert sharp[source].after_mm < 0.2 * rows[source].after_mm


def test_an_unverified_scale_is_named_and_not_counted(shown, identification, campaign):
    _, rows = rows_of(shown, identification, campaign)

    row = rows["Instrument scale"]
    assert english(row.stated) == "scale not verified"
    assert (row.before_mm, row.after_mm) == (None, None)


def test_a_verified_scale_counts_with_its_uncertainty(shown, identification, campaign):
    _, rows = rows_of(shown, identification, campaign, scale=1.0, scale_standard_uncertainty=1e-5)

    assert 0.0 < rows["Instrument scale"].after_mm < 1e-5 * 2000.0  # no point is 2 m away


def test_noise_of_instrument_and_arm_is_not_counted_twice(shown, identification, campaign):
    _, rows = rows_of(shown, identification, campaign)

    assert english(rows["Instrument noise"].stated) == "u = 0.010 mm per axis"
    assert rows["Instrument noise"].after_mm is None
    assert rows["Robot repeatability"].after_mm is None


def test_a_campaign_without_registration_says_that_errors_are_in_the_instruments_frame(
    shown, identification, campaign
):
    _, rows = rows_of(shown, identification, replace(campaign, registration=None))

    assert "instrument's own frame" in english(rows["Registration of the world frame"].remark)
