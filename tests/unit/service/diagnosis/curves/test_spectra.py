"""Spectra: the waves of a finding that has several, and of nothing else."""

import numpy as np
import pytest

from tests.helpers.diagnosis.selections import make_selected, make_start
from truepose.diagnosis.curves import finding_spectrum

WAVES = {
    "joint_harmonics": {
        "wave_4_2_sin": np.deg2rad(0.03),
        "wave_4_3_cos": np.deg2rad(0.04),
        "wave_4_5_sin": np.deg2rad(0.02),
    }
}


def selected_with(*orders):
    picks = [("joint_harmonics", "joint 4", f"wave_4_{order}_sin") for order in orders]
    return make_selected(make_start(WAVES), picks)


def test_several_waves_stand_by_their_order_with_their_amplitudes():
    selected = selected_with(5, 2, 3, 7)

    found = finding_spectrum(selected, selected.picks)

    assert found.order.tolist() == [2.0, 3.0, 5.0, 7.0]
    off = found.amplitude_deg - [0.03, 0.04, 0.02, 0.0]
    assert np.all(np.abs(off) < 4.0 * found.standard_uncertainty_deg)
    assert np.all(found.standard_uncertainty_deg < 0.005)


def test_a_single_wave_needs_no_picture_of_its_orders():
    selected = selected_with(3)

    assert finding_spectrum(selected, selected.picks) is None


@pytest.mark.parametrize("effect", ["joint_gain", "backlash"])
def test_what_is_no_sum_of_waves_has_no_spectrum(effect):
    selected = make_selected(make_start(WAVES), [(effect, "joint 4", None)])

    assert finding_spectrum(selected, selected.picks) is None
