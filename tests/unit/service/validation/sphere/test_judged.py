"""The sphere test: what an arm errs by is found on the bar, and nothing where nothing is."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.spheres import (
    BAR_MM,
    IRB_120,
    NESTS_MM,
    TAUGHT_RAD,
    legs_of,
    longer,
    places_of,
    sphere_campaign,
    stops_on_sphere,
)
from tests.helpers.identification.models import model_of, parameters_of
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import NestCentre
from truepose.domain.robot import Nest
from truepose.messages.catalogue import english
from truepose.validation.sphere_test import sphere_test

LONGER = longer()
MODEL_NESTS = tuple(NestCentre(k, centre) for k, centre in enumerate(NESTS_MM, start=1))


@pytest.fixture(scope="module")
def stops():
    """Configurations on the sphere, and their nests."""
    return stops_on_sphere()


def only(campaign, model=None):
    (sphere,) = sphere_test(campaign, None if model is None else {"knows": model}).spheres
    return sphere


def measured(stops, true=IRB_120, **how):
    joints, nest = stops
    return sphere_campaign(true, joints_rad=joints, nest=nest, **how)


@pytest.mark.parametrize("taught", [True, False])
def test_a_perfect_robot_has_no_errors_and_it_says_so(stops, taught):
    found = only(measured(stops)).of("nominal", taught=taught)

    assert np.abs(found.errors.errors_mm).max() < 1e-8
    assert found.is_noise
    assert not found.whole.mean_mm.is_seen


def test_a_longer_link_is_seen_about_either_centre_and_gone_for_the_model_that_knows_it(stops):
    campaign = measured(stops, LONGER, noise=1.0)
    knows = model_of(IRB_120, *parameters_of("geometry", [("a_3", 0.2, "mm")]), nests=MODEL_NESTS)

    sphere = only(campaign, knows)

    for taught in (True, False):
        before, after = (sphere.of(one, taught=taught) for one in ("nominal", "knows"))
        assert not before.is_noise
        assert after.is_noise
        assert after.whole.sd_mm.value < 0.2 * before.whole.sd_mm.value


def test_models_stand_in_the_order_of_their_accuracy(stops):
    off = [
        model_of(IRB_120, *parameters_of("geometry", [("a_3", by_mm, "mm")]), nests=MODEL_NESTS)
        for by_mm in (-0.2, 0.1, 0.2)
    ]
    models = dict(zip(("wrong way", "half way", "right"), off, strict=True))

    test = sphere_test(measured(stops, LONGER, noise=1.0), models)

    assert [name for name, _ in test.order] == ["right", "half way", "nominal", "wrong way"]
    assert test.order[0][1].value < 0.01
    assert test.order[2][1].value == pytest.approx(2.0 * test.order[1][1].value, rel=0.05)


def test_errors_about_the_taught_centre_are_those_of_the_arm_to_the_last_digit(stops):
    joints, nest = stops
    campaign = measured(stops, LONGER)
    ball, taught = (places_of(arm, TAUGHT_RAD[None], np.ones(1, int))[0] for arm in (LONGER, IRB_120))
    length, predicted = (
        np.linalg.norm(places_of(arm, joints, nest) - centre, axis=1)
        for arm, centre in ((LONGER, ball), (IRB_120, taught))
    )

    found = only(campaign).of("nominal", taught=True)

    error = length - predicted
    assert found.errors.errors_mm == pytest.approx(error, abs=1e-9)
    for number, figures in found.by_nest:
        own = error[nest == number]
        assert figures.n == len(own)
        assert figures.mean_mm.value == pytest.approx(own.mean(), abs=1e-9)
        assert figures.sd_mm.value == pytest.approx(own.std(ddof=1), abs=1e-9)
        assert figures.max_mm.value == pytest.approx(np.abs(own).max(), abs=1e-9)
        assert figures.range_mm.value == pytest.approx(np.ptp(own), abs=1e-9)
        assert figures.max_at == np.flatnonzero(nest == number)[np.abs(own).argmax()]


def test_targets_that_a_model_put_on_the_sphere_show_its_errors_on_the_bar(stops):
    """What the thesis tells, lengths less the bar's, are errors about the taught centre then."""
    sphere = only(measured(stops, LONGER))

    assert sphere.shown_mm == pytest.approx(sphere.of("nominal", taught=True).errors.errors_mm, abs=1e-8)


def test_a_ball_that_was_taught_badly_does_not_move_the_errors_about_the_best_centre(stops):
    campaign = measured(stops)
    off = campaign.setup.joints_rad + 1e-3

    sphere = only(replace(campaign, setup=replace(campaign.setup, joints_rad=off)))

    assert sphere.of("nominal", taught=True).whole.sd_mm.value > 0.1
    assert sphere.of("nominal", taught=False).whole.sd_mm.value < 1e-8


def test_stops_on_one_side_leave_the_best_centre_open():
    test = sphere_test(sphere_campaign(LONGER, per_nest=10, nests=(1,), reach_rad=0.05))

    (sphere,) = test.spheres
    assert sphere.of("nominal", taught=False) is None
    assert sphere.of("nominal", taught=True) is not None
    assert [one.key for one in sphere.withheld] == ["sphere.narrow"]
    assert not test.is_complete


def test_angles_of_another_cell_go_with_no_place_of_the_ball(stops):
    joints, nest = stops
    elsewhere = np.random.default_rng(1).uniform(-2.0, 2.0, joints.shape)

    sphere = only(replace(measured(stops), legs=legs_of(elsewhere, nest, np.full(len(nest), BAR_MM))))

    assert sphere.of("nominal", taught=False) is None
    assert [one.key for one in sphere.withheld] == ["sphere.lost"]


def test_a_ball_that_nobody_says_was_taught_has_its_best_centre_only(stops):
    sphere = only(measured(stops, taught=False))

    assert [one.errors.centre.is_fitted for one in sphere.models] == [True]
    assert english(sphere.withheld[0]).startswith("The taught position of the ball is not stated")


def test_five_lengths_are_too_few(stops):
    joints, nest = stops
    sphere = only(sphere_campaign(joints_rad=joints[:5], nest=nest[:5]))

    assert sphere.models == ()
    assert english(sphere.withheld[0]) == "Lengths to this ball: 5. Six are needed."


def test_a_nest_with_one_length_is_named(stops):
    rows = [*range(10), 79]
    joints, nest = stops

    sphere = only(sphere_campaign(joints_rad=joints[rows], nest=nest[rows]))

    assert (sphere.models, sphere.withheld[0].key) == ((), "sphere.one_of_a_nest")


def test_a_campaign_without_lengths_is_refused(stops):
    with pytest.raises(ConfigurationError, match="there are none"):
        sphere_test(replace(measured(stops), legs=None))


@pytest.mark.parametrize("factor", [1e-3, 1.01])
def test_other_bars_and_another_unit_are_refused(stops, factor):
    joints, nest = stops
    campaign = measured(stops)

    with pytest.raises(ConfigurationError, match="Check the ballbar and the unit"):
        sphere_test(replace(campaign, legs=legs_of(joints, nest, factor * campaign.legs.length_mm)))


def test_a_nest_whose_centre_is_not_known_is_refused(stops):
    campaign = measured(stops)

    with pytest.raises(ConfigurationError, match="The centre of tool nest 2 is not known"):
        sphere_test(replace(campaign, nests=(campaign.nests[0], Nest(None))))


def test_lengths_of_a_bar_that_nobody_named_are_judged_without_it(stops):
    sphere = only(replace(measured(stops), ballbar_nominal_mm=None, ballbar_range_mm=None))

    assert sphere.shown_mm is None
    assert np.abs(sphere.of("nominal", taught=True).errors.errors_mm).max() < 1e-8


def test_each_ball_has_its_own_sphere(stops):
    campaign = measured(stops, LONGER)
    point = np.where(campaign.legs.nest == 1, 1, 2)

    spheres = sphere_test(replace(campaign, legs=replace(campaign.legs, base_point=point))).spheres

    assert [(one.base_point, len(one.config)) for one in spheres] == [(1, 40), (2, 40)]
    # Only ball 1 was taught.
    assert [one.of("nominal", taught=True) is None for one in spheres] == [False, True]


@pytest.mark.parametrize(("held_out", "judged"), [(20, 20), (0, 80)])
def test_held_out_lengths_are_the_test_where_there_are_some(stops, held_out, judged):
    campaign = measured(stops)

    both = replace(campaign, validation_legs=campaign.legs.taken(np.arange(held_out)))

    assert len(only(both).config) == judged


def test_stops_that_are_all_at_one_place_show_no_centre(stops):
    joints, nest = stops
    still = np.repeat(joints[:1], 8, axis=0)

    sphere = only(sphere_campaign(IRB_120, joints_rad=still, nest=np.repeat(nest[:1], 8)))

    assert sphere.of("nominal", taught=False) is None
    assert "plane" in english(sphere.withheld[-1])
