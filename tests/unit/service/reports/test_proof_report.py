"""The page of a proof move: the verdict in one sentence, what warns, and the same numbers as the document."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.web.pages import Page
from truepose.correction.proof import Proof, ProofErrors
from truepose.domain.identification import Statistics
from truepose.messages.catalogue import IN_ENGLISH, catalogue
from truepose.messages.message import message
from truepose.reports.proof import ProofReport
from truepose.reports.traceability import Audit, ReportConditions

PAINTED_ELSEWHERE = pytest.mark.usefixtures("empty_pictures")
N = 12
TRACED = {
    "conditions": ReportConditions(robot_serial_number="120-1", load="2.7 kg"),
    "audit": Audit(7, "5e" * 32, "/api/v1/sessions/7/proof?model_id=3", "d0" * 32, 3, "0d" * 32),
}


def sizes(mean_mm):
    return Statistics(
        n=N, mean_mm=mean_mm, rms_mm=1.1 * mean_mm, sd_mm=0.3 * mean_mm, max_mm=2 * mean_mm, noise_mm=0.02
    )


def proof(gain=12.0, interval=(10.0, 15.0), promised_mm=0.05, cautions=()):
    rng = np.random.default_rng(1)
    target = rng.uniform(-300.0, 300.0, (N, 3))
    before, after = 0.3 * rng.standard_normal((N, 3)), 0.03 * rng.standard_normal((N, 3))
    return Proof(
        before=sizes(0.05 * gain),
        after=sizes(0.05),
        gain=gain,
        gain_interval_95=interval,
        promised_mm=promised_mm,
        foretold_share=1.0,
        cautions=cautions,
        before_relative=sizes(0.04 * gain),
        after_relative=sizes(0.04),
        errors=ProofErrors(np.arange(1, 2 * N, 2), np.ones(N, dtype=int), target, before, after),
    )


def shown(found, words=IN_ENGLISH, **more):
    return ProofReport(found, "ABB IRB 120", "Model 3", **TRACED, language=words.tag, **more).content()


@PAINTED_ELSEWHERE
@pytest.mark.parametrize(
    ("found", "look", "begins"),
    [
        (proof(), "consistent", "The correction is verified. On 12 targets the mean error falls from 0.600"),
        (
            proof(promised_mm=0.01),
            "partly_explained",
            "The correction helps, but less than predicted",
        ),
        (proof(gain=1.1, interval=(0.9, 1.3)), "unexplained", "The correction is not verified"),
        (proof(gain=0.5, interval=(0.4, 0.6)), "unexplained", "The correction increases the error"),
    ],
)
def test_the_verdict_is_one_sentence_with_the_gain_and_its_interval(found, look, begins):
    page = shown(found)
    text = Page(page).text

    low, high = found.gain_interval_95
    assert f'<div class="verdict {look}">' in page
    assert begins in text
    assert f"(95 %: {low:.3g} to {high:.3g})" in text
    assert "Next:" in text


@PAINTED_ELSEWHERE
def test_absolute_and_relative_errors_stand_side_by_side():
    text = Page(shown(proof())).text

    assert "Absolute without correction 12 0.600 0.660 0.180 1.200 0.0200" in text
    assert "Relative without correction 12 0.480" in text


@PAINTED_ELSEWHERE
def test_of_three_targets_no_relative_errors_are_made_up():
    text = Page(shown(replace(proof(), before_relative=None, after_relative=None))).text

    assert "Absolute without correction" in text
    assert "Relative without correction" not in text


@PAINTED_ELSEWHERE
def test_what_speaks_against_the_correction_is_said_before_any_figure():
    other = message("proof.other_serial", made_for="120-2", here="120-1")
    found = proof(0.5, (0.4, 0.6), cautions=(message("proof.corrects_itself", share=0.05),))

    text = Page(shown(found, warnings=(other,))).text

    assert (
        text.index("made from readings of robot 120-2")
        < text.index("the robot is already corrected elsewhere")
        < text.index("Improvement")
    )
    assert "Warning:" not in Page(shown(proof())).text


def test_pictures_targets_conditions_and_records_are_there():
    page = shown(proof())

    assert page.count("<svg") == 3  # shape, distribution, work space
    assert page.count("<tr") > N
    for stated in ("120-1", "2.7 kg", "5e" * 32, "0d" * 32, "d0" * 32, "/api/v1/models/3/file"):
        assert stated in page


def test_it_is_told_in_french():
    text = Page(shown(proof(), catalogue("fr"))).text

    assert "La correction est vérifiée" in text
    assert "Absolues sans correction" in text
    assert "Traçabilité" in text
