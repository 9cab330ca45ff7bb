"""Where targets, nests and sensors are, found from the readings of a nominal arm without a guess."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from truepose.domain.campaign import NO_AXIS
from truepose.domain.contacts import Target, TargetKind
from truepose.identification.model.structure import certified_zeros
from truepose.identification.observations.contact_targets import KINDS
from truepose.identification.problem.contacts import (
    Contacts,
    place_contacts,
    spread_over_targets,
)
from truepose.kinematics.frames import rotation_from_vector

RNG = np.random.default_rng(8)
N = 40
NEST = np.array([40.0, -70.0, 190.0])
FIXTURE = np.array([420.0, -60.0, 240.0])
SQUARE = rotation_from_vector(np.array([[0.2, -0.1, 0.4]]))[0]  # directions of the gauges, in columns
OFF_MM = 0.3  # of the arm, per axis


def three_gauges():
    """A ball of unknown place in the tool at three gauges, within 3 mm, from all sides."""
    rotation = rotation_from_vector(RNG.uniform(-1.5, 1.5, (N, 3)))
    ball = FIXTURE + RNG.uniform(-3.0, 3.0, (N, 3))
    origin = ball - rotation @ NEST + OFF_MM * RNG.standard_normal((N, 3))
    target = np.tile(np.arange(3), N)
    return Contacts(
        rotation=np.repeat(rotation, 3, axis=0),
        origin_mm=np.repeat(origin, 3, axis=0),
        nest=np.ones(3 * N, np.int64),
        target=target,
        axis=np.full(3 * N, NO_AXIS),
        reading_mm=((ball - FIXTURE) @ SQUARE).reshape(-1),
        nests_mm=np.zeros((1, 3)),
        nest_unknown=np.array([True]),
        targets=tuple(Target(k, TargetKind.GAUGE) for k in (1, 2, 3)),
    )


@cache
def found_gauges():
    return place_contacts(three_gauges())


def test_gauges_of_a_few_millimetres_find_the_nest_and_their_directions():
    found = found_gauges()

    # the arm's own errors over the square root of the readings, and over the travel
    assert found.nests_mm[0] == pytest.approx(NEST, abs=0.5)
    for target, direction in zip(found.targets, SQUARE.T, strict=True):
        assert np.dot(target.normal, direction) > np.cos(np.radians(5.0))


def test_what_was_found_is_what_the_fit_begins_about():
    found = found_gauges()

    assert all(values[1:].tolist() == [0.0, 0.0] for values in found.values)  # no slopes are left


@pytest.mark.parametrize("kind", [TargetKind.PLANE, TargetKind.GAUGE])
def test_a_plane_that_is_centred_reads_the_same(kind):
    target = Target(1, kind, place_mm=(10.0, 20.0, 30.0), normal=(0.0, 0.6, 0.8))
    values = np.array([1.5, 2.0, -0.7])
    probe = three_gauges().probe(found_gauges())

    again, others = KINDS[kind].centred(target, values)

    assert KINDS[kind].reading_mm(again, others, probe) == pytest.approx(
        KINDS[kind].reading_mm(target, values, probe), abs=1e-9
    )
    assert others.tolist() == [1.5, 0.0, 0.0]


def test_a_search_looks_at_readings_of_every_target():
    target = np.array([0] * 2000 + [1] * 5)

    rows = spread_over_targets(target)

    assert len(rows) < 300
    assert (target[rows] == 1).sum() == 5


def test_the_zero_of_a_target_is_certified_where_its_certificate_states_it():
    stated, free = (Target(number, TargetKind.SPHERE, zero_mm) for number, zero_mm in ((1, 15.7), (12, None)))

    assert certified_zeros(SimpleNamespace(targets=(stated, free))) == {"target_1_zero"}
