"""What a table of corrected targets came to, in words."""

import numpy as np
import pytest

from truepose.domain.results.corrections import CorrectionTotals
from truepose.reports.corrections import correction_sentences
from truepose.words.catalogue import english


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

    assert "1 of them, a joint by up to 74.1 deg and the last frame by up to 0 mm" in said


@pytest.mark.parametrize(("known", "word"), [(True, None), (False, "does not say")])
def test_nothing_is_said_of_a_zone_that_holds_all_targets(known, word):
    said = " ".join(english(sentence) for sentence in correction_sentences(totals(zone_known=known)))

    assert "extrapolates" not in said
    assert word is None or word in said
