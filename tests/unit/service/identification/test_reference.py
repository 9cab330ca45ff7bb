"""Readings of fixed nests as observations: what moves them, what they decide, and what they leave alone."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.leg_scenes import telling_legs
from tests.helpers.diagnosis.point_scenes import (
    FIXED_MM,
    ORIGIN_S,
    TRACKER_MM,
    telling_campaign,
    telling_scene,
)
from tests.helpers.identification.differences import require_alike
from truepose.domain.robot import FixedNest
from truepose.effects.registry import CAUSES
from truepose.identification import identify
from truepose.identification.fit.assessment import propagate_certificates
from truepose.identification.fit.robust import robust_fit
from truepose.identification.observations.fixed_nests import ReferenceBlock, reference_block
from truepose.identification.problem.build import build
from truepose.messages.catalogue import english

ARM = ("base", "geometry")
FRAME = [f"frame_{component}" for component in ("x", "y", "z", "rx", "ry", "rz")]
NOISE_MM = 0.01


def seen(points, time_s, *, scale=0.0, rate=None, frame=None):
    """What a tracker with these errors reads of points; small turns as cross products."""
    points = points if frame is None else points + frame[:3] + np.cross(frame[3:], points)
    points = points + scale * (points - np.array(TRACKER_MM))
    if rate is None:
        return points
    hours = ((time_s - (ORIGIN_S - 10.0)) / 3600.0)[:, None]
    return points + hours * rate[:3] + np.cross(hours * rate[3:], points)


def measured(rng, n=90, looks=20, frame=None, **errors):
    """A campaign whose tracker has errors; `frame` is that of the fixed nests alone."""
    campaign = telling_campaign(n)
    readings, reference = campaign.calibration, campaign.reference
    times = readings.stops.time_s
    repeated = np.repeat(np.arange(len(reference)), looks // 6)
    looked = replace(
        reference,
        time_s=reference.time_s[repeated],
        fixed_nest=reference.fixed_nest[repeated],
        position_mm=reference.position_mm[repeated],
        standard_uncertainty_mm=np.full(len(repeated), NOISE_MM),
    )

    def noise(count):
        return NOISE_MM * rng.standard_normal((count, 3))

    arm = seen(readings.position_mm, times, **errors) + noise(n)
    fixed = seen(looked.position_mm, looked.time_s, frame=frame, **errors) + noise(len(looked))
    return replace(
        campaign,
        calibration=replace(readings, position_mm=arm, standard_uncertainty_mm=np.full(n, NOISE_MM)),
        reference=replace(looked, position_mm=fixed),
    )


def fitted(campaign, effects, **changes):
    problem = build(campaign, effects, **changes)
    fit = robust_fit(problem.structure, problem.blocks, problem.start)
    names = problem.structure.names
    spread = np.sqrt(np.diag(fit.solution.covariance))
    return {name: (value, u) for name, value, u in zip(names, fit.values, spread, strict=True)}, fit


def test_an_effect_that_moves_the_instrument_brings_the_fixed_nests_along():
    campaign = telling_campaign()

    for effects, asked, there in (
        (ARM, False, False), (ARM, True, True), ((*ARM, "instrument_scale"), False, True),
        ((*ARM, "instrument_drift"), False, True), ((*ARM, "base_drift"), False, False),
    ):  # fmt: skip
        problem = build(campaign, effects, with_reference=asked)

        assert [type(block).__name__ for block in problem.blocks] == (
            ["PositionBlock", "ReferenceBlock"] if there else ["PositionBlock"]
        )
        assert ("reference" in problem.structure.effects) == there
        assert (set(FRAME) <= set(problem.structure.names)) == there
        assert len(problem.start) == len(problem.structure.specs)


@pytest.mark.parametrize("lacking", [{"reference": None}, {"fixed_nests": ()}])
def test_without_certified_nests_or_looks_at_them_there_is_nothing_to_add(lacking):
    campaign = replace(telling_campaign(), **lacking)

    problem = build(campaign, ARM, with_reference=True)

    assert len(problem.blocks) == 1
    assert not set(FRAME) & set(problem.structure.names)


def test_lengths_know_nothing_of_fixed_nests():
    campaign = replace(
        telling_legs(), reference=telling_campaign().reference, fixed_nests=telling_campaign().fixed_nests
    )

    assert len(build(campaign, ("tool", "geometry"), with_reference=True).blocks) == 1


def test_readings_of_fixed_nests_are_stops_of_their_own():
    problem = build(telling_campaign(), ARM, with_reference=True)
    arm, fixed = problem.blocks

    assert isinstance(fixed, ReferenceBlock)
    assert not set(arm.targets.stops.config) & set(fixed.targets.stops.config)
    assert len(set(fixed.targets.stops.config)) == len(fixed.weights) == 18
    assert fixed.scatter_mm == 0.0


def test_priors_of_the_places_are_their_certificates():
    certified = tuple(FixedNest(centre, u) for centre, u in zip(FIXED_MM, (0.001, 0.0, 0.02), strict=True))
    problem = build(replace(telling_campaign(), fixed_nests=certified), ARM, with_reference=True)
    width = {spec.name: spec.prior_width for spec in problem.structure.specs}

    assert [width[f"fixed_{nest}_x"] for nest in (1, 2, 3)] == [0.001, 1e-4, 0.02]


def test_only_nests_that_were_read_have_places():
    campaign = telling_campaign()
    reference = campaign.reference
    looked = replace(reference, fixed_nest=np.where(reference.fixed_nest == 2, 3, reference.fixed_nest))

    names = build(replace(campaign, reference=looked), ARM, with_reference=True).structure.names

    assert {name for name in names if name.startswith("fixed")} == {
        f"fixed_{nest}_{axis}" for nest in (1, 3) for axis in "xyz"
    }


@pytest.mark.parametrize("effects", [ARM, (*ARM, "instrument_scale", "instrument_drift", "base_drift")])
def test_predictions_of_fixed_nests_are_differentiated_exactly(effects):
    problem = build(telling_campaign(), effects, with_reference=True)
    structure, blocks = problem.structure, problem.blocks
    rng = np.random.default_rng(3)
    values = problem.start + 0.3 * structure.prior_widths * rng.standard_normal(len(problem.start))

    def step_of(spec):
        # Widths of certificates are 2 um: larger steps keep the rounding of a metre (1e-13 mm) out of it,
        # and the functions are linear in a place and nearly so in all else.
        return max(1e-4 * spec.prior_width, 1e-3 if spec.unit == "mm" else 0.0)

    require_alike(structure, blocks, values, step_of=step_of)


def test_a_part_of_the_readings_gives_that_part_of_the_result():
    problem = build(telling_campaign(), (*ARM, "instrument_drift"))
    block = problem.blocks[1]
    values = problem.start + 0.1 * problem.structure.prior_widths
    rows = np.array([2, 7, 16])

    whole = block.result(problem.structure, values, None)
    part = block.taken(rows).result(problem.structure, values, None)

    assert part.residual == pytest.approx(whole.residual[rows])
    assert part.jacobian == pytest.approx(whole.jacobian[:, rows])
    assert block.weighted(np.zeros(18), 0.5).component_variance() == pytest.approx(0.015**2 + 0.25)


def test_a_tracker_that_drifts_and_one_that_reads_too_long_are_found_with_their_uncertainties():
    rng = np.random.default_rng(11)
    rate = np.array([0.3, -0.2, 0.1, 2e-4, 1e-4, -3e-4])
    campaign = measured(rng, scale=3e-5, rate=rate, frame=np.array([0.02, -0.01, 0.03, 1e-5, -2e-5, 3e-5]))

    found, fit = fitted(campaign, (*ARM, "instrument_scale", "instrument_drift"))

    components = ("x", "y", "z", "rx", "ry", "rz")
    truth = {"scale": 3e-5} | {f"tracker_linear_{c}": r for c, r in zip(components, rate, strict=True)}
    scores = [(found[name][0] - value) / found[name][1] for name, value in truth.items()]
    # seven normal scores: their squares exceed 24.3 once in a thousand
    assert np.sum(np.square(scores)) < 24.3
    assert found["scale"][1] < 6e-6
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=0.3)  # about 400 degrees of freedom: 0.07 is usual


def test_a_base_that_drifts_is_told_from_a_tracker_that_does_by_nests_that_stand_still():
    rng = np.random.default_rng(12)
    campaign = measured(rng)
    hours = (campaign.calibration.stops.time_s - (ORIGIN_S - 10.0)) / 3600.0
    readings = campaign.calibration
    moving = replace(
        campaign,
        calibration=replace(readings, position_mm=readings.position_mm + hours[:, None] * [0.4, 0.0, 0.0]),
    )

    found, _ = fitted(moving, (*ARM, "base_drift", "instrument_drift"))

    base, tracker = found["drift_linear_x"], found["tracker_linear_x"]
    assert base[0] == pytest.approx(0.4, abs=4.0 * base[1])
    assert abs(tracker[0]) < 4.0 * tracker[1]
    assert base[1] < 0.05


def test_the_registration_of_the_fixed_nests_leaves_the_arm_where_it_is():
    """The readings of the arm share that error, and its base takes it: nothing may leak into the rest."""
    frame = np.array([0.2, -0.1, 0.3, 1e-4, -2e-4, 3e-4])
    straight, _ = fitted(measured(np.random.default_rng(13)), ARM, with_reference=True)
    shifted, _ = fitted(measured(np.random.default_rng(13), frame=frame), ARM, with_reference=True)

    for name, (value, spread) in straight.items():
        if name in FRAME:
            change = frame[FRAME.index(name)]
            # certificates of 2 um leave the frame open by as much
            assert shifted[name][0] - value == pytest.approx(change, abs=5e-3 if "_r" not in name else 1e-5)
        elif not name.startswith("fixed"):
            assert abs(shifted[name][0] - value) < 1e-3 * spread


def test_what_certificates_add_to_the_arm_is_the_same_with_fixed_nests_among_the_readings():
    campaign = measured(np.random.default_rng(14))
    _, alone = fitted(campaign, ARM)
    _, together = fitted(campaign, ARM, with_reference=True)
    arm = len(alone.values)

    plain, with_nests = propagate_certificates(campaign, alone), propagate_certificates(campaign, together)

    own = np.s_[:arm, :arm]
    scale = np.sqrt(np.outer(np.diag(plain.total), np.diag(plain.total)))
    # The two fits end within a thousandth of an uncertainty of each other.
    assert with_nests.total[own] / scale == pytest.approx(plain.total[own] / scale, abs=5e-3)
    assert not with_nests.registration[arm:, arm:].any()


def test_one_bad_look_at_a_fixed_nest_counts_for_nothing_and_is_no_outlier_of_the_calibration():
    campaign = measured(np.random.default_rng(15))
    position = campaign.reference.position_mm.copy()
    position[4] += [0.0, 1.0, 0.0]
    spoilt = replace(campaign, reference=replace(campaign.reference, position_mm=position))

    _, fit = fitted(spoilt, (*ARM, "instrument_drift"))
    answer = identify(spoilt, (*ARM, "instrument_drift"))

    assert np.flatnonzero(fit.gross[1]).tolist() == [4]
    assert answer.outliers == ()
    assert answer.counts.outliers == 0
    assert "1 reading of reference nests without weight" in english(answer.message)


def test_what_fixed_nests_leave_open_of_themselves_is_not_named_as_undetermined():
    answer = identify(measured(np.random.default_rng(16)), (*ARM, "instrument_drift"))

    named = {name for entry in answer.not_identifiable for name in entry.parameters}
    assert not any(name.startswith(("frame", "fixed")) for name in named)


def test_time_counts_from_the_first_reading_fixed_nests_included():
    campaign = telling_campaign()
    readings = campaign.calibration
    unknown = replace(readings, stops=replace(readings.stops, time_s=None))
    later = np.where(np.arange(24) == 0, np.nan, readings.stops.time_s)
    gap = replace(readings, stops=replace(readings.stops, time_s=later))

    def origin(**changes):
        return build(replace(campaign, **changes), ARM).structure.origin_s

    assert origin() == ORIGIN_S - 10.0
    assert origin(reference=None) == ORIGIN_S
    assert origin(calibration=unknown, reference=None) == 0.0
    assert origin(calibration=gap, reference=None) == ORIGIN_S + 30.0


def test_readings_of_nests_without_a_certificate_are_passed_over():
    campaign = telling_campaign()

    block = reference_block(replace(campaign, fixed_nests=campaign.fixed_nests[:2]))

    assert set(block.fixed_nest) == {1, 2}
    assert len(block.targets) == len(block.measured_mm) == 12


@pytest.mark.parametrize("cause", [name for name in CAUSES if name not in {"ballbar_zero", "fixture_shift"}])
def test_of_all_causes_only_those_of_the_instrument_move_fixed_nests(cause):
    problem = build(telling_campaign(), ARM, with_reference=True)
    block = problem.blocks[1]
    candidates = CAUSES[cause].candidates(telling_scene(ARM))[:3]
    structure = problem.structure
    for candidate in candidates:
        new = tuple(spec for spec in candidate.specs if spec.name not in structure.names)
        structure = structure.extended(cause, new)
    own = [k for k, owner in enumerate(structure.owners) if owner == cause]
    values = np.concatenate([problem.start, structure.prior_widths[own]])

    result = block.result(structure, values, None)

    moved = block.measured_mm - result.residual
    assert np.isfinite(result.residual).all()
    assert np.isfinite(result.jacobian).all()
    if cause in {"instrument_drift", "instrument_scale"}:
        assert np.abs(result.jacobian[own]).max() > 0.0
        assert np.abs(moved - block.certified_mm).max() > 1e-3
    else:
        assert not result.jacobian[own].any()
        assert moved == pytest.approx(block.certified_mm, abs=1e-12)
