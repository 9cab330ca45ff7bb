"""The proof move: what pairs of readings say of a correction, and when they say nothing."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, plain_parameters
from tests.helpers.identification.proved import SCATTER_MM, model, visited
from truepose.correction.proof import proof_of
from truepose.domain.errors import ConfigurationError
from truepose.exchange.results.corrections import proof_document


def nominal():
    """The model without anything identified."""
    return replace(model(), parameters=(), effects=(), covariance=np.zeros((0, 0)))


def test_a_model_that_is_the_robot_is_proved_and_keeps_its_promise():
    proof = proof_of(model(), visited(model()), SCATTER_MM)

    assert proof.proved
    assert proof.foretold_share == pytest.approx(1.0, abs=0.02)
    assert proof.after.mean_mm == pytest.approx(proof.promised_mm, rel=0.15)
    assert proof.gain_interval_95[0] < proof.gain < proof.gain_interval_95[1]
    assert proof.gain > 10.0
    assert proof.cautions == ()


def test_the_relative_errors_do_not_see_where_the_robot_stands():
    readings = visited(model())
    pushed = replace(readings, position_mm=readings.position_mm + np.array([0.3, 0.0, 0.0]))

    as_read, moved = (proof_of(model(), points, SCATTER_MM) for points in (readings, pushed))

    assert moved.after.mean_mm > as_read.after.mean_mm + 0.2
    assert moved.after_relative.mean_mm == pytest.approx(as_read.after_relative.mean_mm)
    assert as_read.before_relative.mean_mm < as_read.before.mean_mm


def test_three_targets_have_no_relative_errors_as_alignment_would_take_nearly_all():
    few = visited(model()).taken(np.arange(6))

    proof = proof_of(model(), few, SCATTER_MM)

    assert proof.before_relative is None
    assert proof_document(proof).after_relative is None


def test_the_document_has_the_errors_of_each_target():
    proof = proof_of(model(), visited(model()), SCATTER_MM)

    told = proof_document(proof)

    assert told.targets == len(told.errors.config) == len(told.errors.after_mm)
    norms = np.linalg.norm(told.errors.after_mm, axis=1)
    assert norms.mean() == pytest.approx(told.after.mean_mm)
    assert told.errors.config[:2] == [1, 3]


def test_a_controller_that_corrects_itself_is_suspected():
    # what the model foretells is made up for already: the robot is as its nominal model, and corrected twice
    proof = proof_of(model(), visited(nominal(), believed=model()), SCATTER_MM)

    assert not proof.proved
    assert proof.gain < 1.0
    assert abs(proof.foretold_share) < 0.1
    assert [caution.key for caution in proof.cautions] == ["proof.corrects_itself"]


def test_a_model_of_another_robot_breaks_its_promise():
    proof = proof_of(model(1), visited(model(2), believed=model(1)), SCATTER_MM)

    assert not proof.keeps_promise
    assert not proof.proved


def test_where_there_is_nothing_to_correct_nothing_is_proved():
    nothing = model_of(IRB_120, *plain_parameters(IRB_120)[:1], repeatability_mm=SCATTER_MM)
    nothing = replace(
        nothing, parameters=(replace(nothing.parameters[0], value=1e-9),), nominal_base=nothing.base
    )

    proof = proof_of(nothing, visited(nothing), SCATTER_MM)

    assert not proof.proved
    assert proof.gain == pytest.approx(1.0, abs=0.3)


def test_a_model_that_foretells_no_error_shares_none_and_accuses_nobody():
    proof = proof_of(nominal(), visited(nominal()), SCATTER_MM)

    assert np.isnan(proof.foretold_share)
    assert proof.cautions == ()
    assert not proof.proved


def test_a_target_with_one_reading_is_left_out_and_without_pairs_there_is_no_proof():
    readings = visited(model())
    kept = np.delete(np.arange(len(readings)), [1, 6])

    assert proof_of(model(), readings.taken(kept), SCATTER_MM).before.n == len(readings) // 2 - 2
    with pytest.raises(ConfigurationError, match="at least two targets"):
        proof_of(model(), readings.taken(np.arange(0, len(readings), 2)), SCATTER_MM)


def test_of_several_readings_of_one_stop_none_wins_silently():
    readings = visited(model())
    twice = readings.taken(np.append(np.arange(len(readings)), 2))

    with pytest.raises(ConfigurationError, match="Configuration 3 was read 2 times"):
        proof_of(model(), twice, SCATTER_MM)


def test_readings_of_another_plan_are_refused():
    with pytest.raises(ConfigurationError, match="cannot prove this model"):
        proof_of(model(1), visited(model(2)), SCATTER_MM)


def test_readings_that_lie_exactly_on_their_targets_have_a_gain_that_is_a_number():
    foretold = visited(model())
    errors = proof_of(model(), foretold, SCATTER_MM).errors
    exact = foretold.position_mm.copy()
    exact[np.isin(foretold.stops.config, errors.config + 1)] -= errors.after_mm

    proof = proof_of(model(), replace(foretold, position_mm=exact), SCATTER_MM)

    assert np.isfinite([proof.gain, *proof.gain_interval_95]).all()
    assert proof.gain > 1e5
