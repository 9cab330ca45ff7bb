import re
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.builders import make_model
from tests.helpers.web.pages import assert_drawn_for_pages
from truepose.identification import predict
from truepose.messages.catalogue import catalogue
from truepose.reports.figures.error_maps import exaggeration, work_space
from truepose.reports.figures.histograms import histogram
from truepose.reports.figures.joint_residuals import eye_guide, joint_residuals, residuals_by_joint
from truepose.reports.figures.svg_rendering import new_figure, on_page
from truepose.reports.identification.judged_figures import judged
from truepose.reports.identification.observability import correlation_map, correlation_matrix, strongest_pairs


@pytest.fixture(scope="session")
def pictures(identification, campaign):
    shown = judged(identification, campaign)
    space = work_space(shown)
    return {
        "histogram": histogram(shown, 0.016).picture,
        "joints": joint_residuals(shown).picture,
        "space": space.in_space,
        "views": space.views,
        "correlation": correlation_map(identification.model),
    }


@pytest.mark.parametrize("name", ["histogram", "joints", "space", "views", "correlation"])
def test_a_picture_is_well_formed_and_takes_its_colours_from_the_page(pictures, name):
    assert_drawn_for_pages(pictures[name])


@pytest.mark.parametrize(("noise_mm", "drawn"), [(0.016, True), (0.0, False), (1e-9, False)])
def test_noise_is_in_the_legend_only_where_its_line_is_drawn(identification, campaign, noise_mm, drawn):
    made = histogram(judged(identification, campaign), noise_mm)

    assert made.noise_drawn is drawn
    assert ("noise alone" in made.picture) is drawn


def test_joints_that_stood_still_have_no_guide_and_certain_readings_no_band(identification, campaign):
    shown = judged(identification, campaign)
    moved = joint_residuals(shown)
    still = replace(shown.block.targets, stops=replace(shown.stops, joints_rad=np.zeros((60, 3))))
    certain = replace(shown.block, targets=still, covariance_mm2=np.zeros((60, 3, 3)))
    silent = replace(shown, block=certain)

    made = joint_residuals(silent)

    assert (moved.guides, moved.band) == (True, True)
    assert (made.guides, made.band) == (False, False)
    assert "2 u of the instrument" in moved.picture
    assert "2 u of the instrument" not in made.picture


def test_ids_of_different_pictures_do_not_meet(pictures):
    found = [set(re.findall(r'\bid="([^"]+)"', svg)) for svg in pictures.values()]

    assert sum(map(len, found)) == len(set().union(*found))


def test_references_within_a_picture_find_their_target(pictures):
    for svg in pictures.values():
        ids = set(re.findall(r'\bid="([^"]+)"', svg))
        assert set(re.findall(r'href="#([^"]+)"', svg)) <= ids
        assert set(re.findall(r"url\(#([^)]+)\)", svg)) <= ids


@pytest.mark.parametrize(("error_mm", "factor"), [(0.02, 5000.0), (1.0, 100.0), (1e4, 1.0)])
def test_errors_are_exaggerated_by_a_round_factor_and_never_shrunk(error_mm, factor):
    points = np.array([[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0]])

    assert exaggeration(points, np.full((2, 3), error_mm / np.sqrt(3.0))) == factor


def test_points_without_error_or_extent_are_not_exaggerated():
    assert exaggeration(np.zeros((2, 3)), np.ones((2, 3))) == 1.0
    assert exaggeration(np.eye(3), np.zeros((3, 3))) == 1.0


def test_a_joint_that_turns_too_far_is_seen_along_its_own_motion(identification, campaign):
    shown, model = judged(identification, campaign), identification.model
    turned = replace(shown.stops, joints_rad=shown.stops.joints_rad + np.array([0.0, 1e-5, 0.0]))
    moved, _ = predict(model, turned, shown.block.targets.nest)
    shown = replace(shown, identified=replace(shown.identified, residual=moved - shown.position_mm))

    seen = residuals_by_joint(shown)

    length = np.linalg.norm(shown.identified_mm, axis=1)
    # 1e-5 rad of a circle departs from its tangent by half of 1e-5 of its length.
    assert seen[1, :, 0] == pytest.approx(length, rel=1e-5)
    assert np.abs(seen[1, :, 1:]).max() < 1e-5 * length.max()


def test_the_split_keeps_the_length_of_every_residual(identification, campaign):
    shown = judged(identification, campaign)

    seen = residuals_by_joint(shown)

    expected = np.broadcast_to(np.linalg.norm(shown.identified_mm, axis=1), seen.shape[:2])
    assert np.linalg.norm(seen, axis=2) == pytest.approx(expected, rel=1e-12)


def test_the_eye_guide_follows_a_wave_of_the_joint():
    angle = np.linspace(-90.0, 90.0, 400)

    grid, guide = eye_guide(angle, 0.05 * np.sin(np.radians(2.0 * angle)))

    inner = np.abs(grid) < 60.0
    # A normal kernel of 7.2 deg damps two periods per turn by exp(-(2 * 0.1257)^2 / 2) = 0.969.
    expected = 0.969 * 0.05 * np.sin(np.radians(2.0 * grid))
    assert guide[inner] == pytest.approx(expected[inner], abs=0.001)  # the cut and the sum for an integral


def test_the_eye_guide_is_not_drawn_where_few_readings_stand():
    angle = np.concatenate([np.linspace(-90.0, -80.0, 50), np.linspace(80.0, 90.0, 50)])

    grid, guide = eye_guide(angle, np.full(100, 0.01))

    assert np.isnan(guide[np.abs(grid) < 30.0]).all()


def test_a_joint_that_did_not_move_has_no_guide():
    grid, _ = eye_guide(np.full(10, 30.0), np.ones(10))

    assert grid.size == 0


def test_correlations_are_those_of_the_covariance_and_the_strong_ones_are_named():
    model = make_model(covariance=np.array([[1e-8, -9e-7], [-9e-7, 1e-4]]))

    assert correlation_matrix(model) == pytest.approx(np.array([[1.0, -0.9], [-0.9, 1.0]]))
    assert strongest_pairs(model) == (("alpha_2", "a_3", pytest.approx(-0.9)),)


def test_a_parameter_of_no_variance_correlates_with_nothing():
    model = make_model(covariance=np.diag([0.0, 1e-4]))

    assert correlation_matrix(model) == pytest.approx(np.eye(2))


def test_words_that_this_machine_has_no_font_for_are_left_to_the_reader_s():
    def draw(colours):
        figure = new_figure(2.0, 2.0)
        figure.subplots().set_xlabel("誤差 [mm]", color=colours.ink)
        return figure

    assert "誤差 [mm]" in on_page(draw, "a", "", catalogue("ja"))  # and warns of nothing
