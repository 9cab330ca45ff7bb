"""What a table of corrected targets came to, in words."""

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, parameters_of
from tests.helpers.identification.synthetic import configurations
from truepose.correction import Summary, correct, goals_of_joints
from truepose.domain.campaign import Stops
from truepose.domain.correction import CorrectionTotals
from truepose.messages.catalogue import english
from truepose.reports.correction import correction_sentences


def totals(**changes):
    stated = {
        "statuses": {"ok": 1},
        "failed": (),
        "largest_error_mm": 0.0,
        "mean_uncertainty_mm": 0.05,
        "largest_uncertainty_mm": 0.05,
        "far_moved": 0,
        "largest_move_rad": 0.0,
        "outside": 0,
        "farthest_outside_mm": 0.0,
        "farthest_outside_rad": 0.0,
        "zone_known": True,
    }
    return CorrectionTotals(**stated | changes)


def test_a_joint_outside_the_measured_zone_is_told_where_the_last_frame_is_within():
    outside = totals(outside=1, farthest_outside_rad=np.radians(74.1))

    said = " ".join(english(sentence) for sentence in correction_sentences(outside))

    assert (
        "1 of the corrected targets are outside the measured zone, by up to 74.1 deg in a joint "
        "and 0 mm in position" in said
    )


@pytest.mark.parametrize(("known", "word"), [(True, None), (False, "does not state")])
def test_nothing_is_said_of_a_zone_that_holds_all_targets(known, word):
    said = " ".join(english(sentence) for sentence in correction_sentences(totals(zone_known=known)))

    assert "extrapolates" not in said
    assert word is None or word in said


def test_a_model_that_does_not_know_its_uncertainty_promises_nothing():
    lone = parameters_of("geometry", [("a_3", 0.2, "mm")])
    model = model_of(IRB_120, *lone, covariance=np.full((1, 1), np.nan))
    goals, summary = goals_of_joints(model, Stops(np.arange(3), configurations(3))), Summary()
    summary.add(["P1", "P2", "P3"], correct(model, goals))

    done, said, *_ = correction_sentences(summary.totals)

    assert "3 of 3" in english(done)
    assert "does not state the uncertainty" in english(said)
    assert np.isnan(summary.totals.largest_uncertainty_mm)
