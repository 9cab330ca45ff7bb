import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from service.reports.figures.correlation import correlation_map, correlation_matrix, strongest_pairs
from service.reports.figures.histogram import histogram
from service.reports.figures.joint_residuals import eye_guide, joint_residuals
from service.reports.figures.work_space import exaggeration, work_space
from service.reports.judged import judged
from tests.builders import make_model


@pytest.fixture(scope="session")
def pictures(identification, campaign):
    shown = judged(identification, campaign)
    space = work_space(shown)
    return {
        "histogram": histogram(shown),
        "joints": joint_residuals(shown),
        "space": space.in_space,
        "views": space.views,
        "correlation": correlation_map(identification.model),
    }


@pytest.mark.parametrize("name", ["histogram", "joints", "space", "views", "correlation"])
def test_a_picture_is_well_formed_and_takes_its_colours_from_the_page(pictures, name):
    svg = pictures[name]

    root = ElementTree.fromstring(svg)

    assert root.tag.endswith("svg")
    assert "width" not in root.attrib
    assert root.attrib["role"] == "img"
    assert root.attrib["aria-label"]
    assert "var(--ink)" in svg
    assert not re.search(r"#0[1-9a]0[1-9a]0[1-9a]", svg)  # no stand-in colour is left


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


def test_the_eye_guide_follows_a_wave_of_the_joint():
    angle = np.linspace(-90.0, 90.0, 400)

    grid, guide = eye_guide(angle, 0.05 * np.sin(np.radians(2.0 * angle)))

    inner = np.abs(grid) < 60.0
    # A normal kernel of 14.4 deg damps two periods per turn by exp(-(2 * 0.251)^2 / 2) = 0.88.
    expected = 0.88 * 0.05 * np.sin(np.radians(2.0 * grid))
    assert guide[inner] == pytest.approx(expected[inner], abs=0.004)


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
