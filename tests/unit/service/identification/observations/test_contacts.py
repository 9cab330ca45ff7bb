"""Contacts with targets of unknown place: predicted as geometry says, differentiated exactly."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.helpers.identification.closed_loops import (
    NORMALS,
    PLACES,
    contact_campaign,
    with_distance,
)
from truepose.domain.contacts import SEEN_ALONG_AXES, Target, TargetKind
from truepose.identification.observations.contact_targets import KINDS, Probe
from truepose.identification.problem.build import build

CAMPAIGNS = {
    "sphere of unknown radius": contact_campaign(TargetKind.SPHERE),
    "certified radius": contact_campaign(TargetKind.SPHERE, zero_mm=25.0, zero_uncertainty_mm=0.01),
    "two spheres": with_distance(contact_campaign(TargetKind.SPHERE)),
    "wire": contact_campaign(TargetKind.WIRE, zero_mm=0.0, known_nests=False),
    "plane": contact_campaign(TargetKind.PLANE, known_nests=False),
    "gauge": contact_campaign(TargetKind.GAUGE),
    "ball": contact_campaign(TargetKind.BALL, known_nests=False),
    "face": contact_campaign(TargetKind.FACE, n=120),
}

FLAT = (TargetKind.PLANE, TargetKind.GAUGE, TargetKind.FACE)
OWN = {kind: 4 if kind in (TargetKind.SPHERE, TargetKind.WIRE) else 3 for kind in KINDS}


@cache
def problem_of(name):
    campaign = CAMPAIGNS[name]
    tool = campaign.nests[0].centre_mm is None or campaign.targets[0].kind in SEEN_ALONG_AXES
    return build(campaign, ("tool", "geometry", "instrument_scale") if tool else ("geometry",))


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_contacts_are_differentiated_exactly(name):
    problem = problem_of(name)
    structure = problem.structure
    steps = np.minimum(structure.prior_widths, 1.0)
    values = problem.start + 0.3 * steps * np.random.default_rng(3).standard_normal(len(steps))

    for block in (whole.taken(np.arange(0, len(whole.weights), 7)) for whole in problem.blocks):
        analytic = block.result(structure, values, None).jacobian
        for k, spec in enumerate(structure.specs):
            step = 1e-4 * min(spec.prior_width, 1.0)
            ahead, behind = (
                block.result(structure, values + sign * step * np.eye(len(values))[k], None).residual
                for sign in (1.0, -1.0)
            )
            slope = (behind - ahead) / (2.0 * step)
            # smooth functions at steps of 1e-4 widths; rounding of metres over the smallest step
            assert analytic[k] == pytest.approx(slope, abs=1e-6 * np.abs(slope).max() + 1e-6), spec.name


@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_is_differentiated_as_complex_steps_say(kind):
    target, rng = (
        Target(1, kind, None, place_mm=(10.0, 20.0, 30.0), normal=(0.2, 0.3, 0.9)),
        np.random.default_rng(1),
    )
    probe = Probe(100.0 * rng.standard_normal((5, 3)), rng.standard_normal((5, 3)))
    values = (
        np.array([0.5, 0.1, -0.2]) if kind in (TargetKind.PLANE, TargetKind.GAUGE) else rng.uniform(5, 9, 3)
    )
    if kind in (TargetKind.SPHERE, TargetKind.WIRE):
        values = np.append(values, 12.0)

    slope = KINDS[kind].slope(target, values, probe)

    def read(place, along, own):
        return complex_reading(kind, target, own, place, along)

    step = 1e-20
    for axis in range(3):
        moved = probe.place_mm + 1j * step * np.eye(3)[axis]
        assert slope.place[:, axis] == pytest.approx(read(moved, probe.along, values).imag / step, rel=1e-12)
        turned = probe.along + 1j * step * np.cross(np.eye(3)[axis], probe.along)
        assert slope.turn[:, axis] == pytest.approx(
            read(probe.place_mm, turned, values).imag / step, rel=1e-12, abs=1e-12
        )
    for k in range(len(values)):
        other = values + 1j * step * np.eye(len(values))[k]
        assert slope.own[k] == pytest.approx(read(probe.place_mm, probe.along, other).imag / step, rel=1e-11)
    assert KINDS[kind].reading_mm(target, values, probe) == pytest.approx(
        read(probe.place_mm + 0j, probe.along, values).real, rel=1e-13
    )


def complex_reading(kind, target, own, place, along):
    """The reading by the formula alone, of complex numbers."""
    if kind in FLAT:
        start = np.array(target.normal) / np.linalg.norm(target.normal)
        first = np.cross([1.0, 0.0, 0.0], start)  # the smallest component of the normal is x
        first /= np.linalg.norm(first)
        normal = start + own[1] * first + own[2] * np.cross(start, first)
        unit = normal / np.sqrt((normal**2).sum())
        height = (place - np.array(target.place_mm)) @ unit - own[0]
        return -height / (along @ unit) if kind is TargetKind.FACE else height
    arm = place - own[:3]
    if kind is TargetKind.BALL:
        return -(arm * along).sum(axis=1)
    return np.sqrt((arm**2).sum(axis=1)) - own[3]


def found(problem, target, names="xyz"):
    values = dict(zip(problem.structure.names, problem.start, strict=True))
    return np.array([values[f"target_{target}_{name}"] for name in names])


@pytest.mark.parametrize("name", ["sphere of unknown radius", "two spheres", "wire", "ball"])
def test_centres_are_found_without_a_guess(name):
    problem = problem_of(name)

    for target in (1, 2, 3):
        # a robot without errors: what is left is the noise of 60 readings
        assert found(problem, target) == pytest.approx(PLACES[target - 1], abs=0.02)


@pytest.mark.parametrize("name", ["plane", "gauge", "face"])
def test_planes_are_found_without_a_guess_and_on_the_side_on_which_readings_grow(name):
    problem = problem_of(name)

    for target, normal in zip(problem.structure.targets, NORMALS, strict=True):
        own = found(problem, target.number, ("shift", "slope1", "slope2"))
        somewhere = Probe(np.zeros((1, 3)), np.zeros((1, 3)))
        # a robot without errors: what is left is the noise of 60 readings over half a metre
        seen = KINDS[TargetKind.PLANE].slope(target, own, somewhere).place[0]
        seen = seen if name != "face" else np.copysign(1.0, seen @ normal) * seen  # from either side alike
        assert seen == pytest.approx(normal, abs=3e-4)


def test_places_that_are_told_are_started_from():
    campaign = contact_campaign(TargetKind.SPHERE)
    told = tuple(
        replace(target, place_mm=tuple(place + 3.0))
        for target, place in zip(campaign.targets, PLACES, strict=True)
    )

    problem = build(replace(campaign, targets=told), ("geometry",))

    assert found(problem, 2) == pytest.approx(PLACES[1], abs=0.02)


def test_a_target_that_nothing_was_read_against_has_no_parameters():
    campaign = contact_campaign(TargetKind.SPHERE)
    here = np.flatnonzero(campaign.contacts.target != 2)

    problem = build(with_distance(campaign.of_rows(here)), ("geometry",))

    assert [target.number for target in problem.structure.targets] == [1, 3]
    assert len(problem.blocks) == 1  # and a certified distance to it says nothing


def test_the_form_of_a_target_is_in_the_weight_of_each_reading():
    rough = contact_campaign(TargetKind.PLANE, form_mm=0.03)

    (block,) = build(rough, ("geometry",)).blocks

    assert block.uncertainty_mm == pytest.approx(np.hypot(0.002, 0.03))
