"""The size of a closed loop, as a direction that readings may leave open."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.closed_loops import contact_campaign
from truepose.domain.targets import TargetKind
from truepose.identification.problem.build import build
from truepose.identification.verdict.size import size_direction, split_off_size
from truepose.identification.verdict.status import too_few_data

LOOP = contact_campaign(TargetKind.SPHERE)
STRUCTURE = build(LOOP, ("geometry",)).structure


def orthonormal(*columns):
    return np.linalg.qr(np.column_stack(columns))[0]


def test_the_size_is_split_off_what_is_left_open_and_the_rest_stays():
    grown = size_direction(STRUCTURE)
    other = np.eye(len(grown))[STRUCTURE.index_of("alpha_5")]

    size, rest = split_off_size(STRUCTURE, orthonormal(grown + 0.2 * other, other))

    assert abs(size @ grown) == pytest.approx(1.0)
    assert rest.shape[1] == 1
    assert abs(rest[:, 0] @ other) == pytest.approx(1.0)


def test_where_the_size_is_told_nothing_is_split_off():
    grown = size_direction(STRUCTURE)
    across = np.zeros(len(grown))
    across[[STRUCTURE.index_of("a_3"), STRUCTURE.index_of("alpha_3")]] = 0.1, 1.0
    space = orthonormal(across)

    size, rest = split_off_size(STRUCTURE, space)

    assert size is None
    assert rest is space


def test_a_model_without_lengths_has_no_size():
    angles = [k for k, name in enumerate(STRUCTURE.names) if not name.startswith(("a_", "d_"))]

    assert size_direction(STRUCTURE.kept(np.array(angles))) is None


def test_touches_that_all_read_nothing_may_be_enough():
    still = replace(LOOP, contacts=replace(LOOP.contacts, reading_mm=np.zeros(len(LOOP.contacts))))

    assert too_few_data(still, ("geometry",)) is None
