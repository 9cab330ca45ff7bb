"""The size of a closed loop, as a direction that readings may leave open."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.closed_loops import contact_campaign
from truepose.domain.contacts import TargetKind
from truepose.identification.problem.build import build
from truepose.identification.verdict.identifiability import size_direction, size_left_open, without
from truepose.identification.verdict.status import too_few_data

LOOP = contact_campaign(TargetKind.SPHERE)
STRUCTURE = build(LOOP, ("geometry",)).structure


GROWN = size_direction(STRUCTURE)


def known(directions, deviations):
    """Variances and directions of a posterior that is 0.01 of the prior, but along `directions`."""
    first = np.linalg.qr(np.column_stack(directions))[0]
    rest = np.linalg.svd(first, full_matrices=True)[0][:, first.shape[1] :]
    return np.array([*deviations, *[0.01] * rest.shape[1]]) ** 2, np.hstack([first, rest])


def direction_of(name):
    return np.eye(len(GROWN))[STRUCTURE.index_of(name)]


def test_a_size_that_is_hardly_known_is_left_open():
    size = size_left_open(STRUCTURE, *known([GROWN + 0.2 * direction_of("alpha_5")], [0.3]))

    assert size @ GROWN > 0.95


def test_a_size_that_is_known_to_a_part_of_its_prior_is_not():
    assert size_left_open(STRUCTURE, *known([GROWN], [0.1])) is None


def test_one_length_alone_is_not_the_size():
    assert size_left_open(STRUCTURE, *known([direction_of("a_3")], [0.9])) is None


def test_readings_from_known_places_have_a_size():
    assert size_left_open(replace(STRUCTURE, targets=()), *known([GROWN], [0.9])) is None


def test_what_is_left_open_besides_is_across_the_size():
    space = np.linalg.qr(np.column_stack([GROWN, direction_of("alpha_5"), direction_of("alpha_6")]))[0]

    rest = without(space, GROWN)

    assert rest.shape[1] == 2
    assert np.abs(GROWN @ rest).max() < 1e-12
    assert np.linalg.norm(direction_of("alpha_5") @ rest) == pytest.approx(1.0)


def test_a_space_without_the_size_stays_as_it_is():
    space = direction_of("alpha_5")[:, None]

    assert without(space, GROWN) is space


def test_a_model_without_lengths_has_no_size():
    angles = [k for k, name in enumerate(STRUCTURE.names) if not name.startswith(("a_", "d_"))]

    assert size_direction(STRUCTURE.kept(np.array(angles))) is None


def test_touches_that_all_read_nothing_may_be_enough():
    still = replace(LOOP, contacts=replace(LOOP.contacts, reading_mm=np.zeros(len(LOOP.contacts))))

    assert too_few_data(still, ("geometry",)) is None
