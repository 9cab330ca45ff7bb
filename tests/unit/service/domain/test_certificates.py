from datetime import date

import pytest

from truepose.domain.cell import Closing, Paper, judged_papers
from truepose.messages.catalogue import english

TODAY = date(2026, 11, 23)


@pytest.mark.parametrize(
    ("certificate", "expires", "standing"),
    [
        ("report 7", "2027-11-23", "holds"),
        ("report 7", "2026-12-24", "holds"),
        ("report 7", "2026-12-23", "ends soon"),
        ("report 7", "2026-11-23", "ends soon"),  # its last day counts
        ("report 7", "2026-11-22", "expired"),
        ("report 7", "", "undated"),
        ("", "2027-11-23", "missing"),
        ("  ", "", "missing"),
    ],
)
def test_a_certificate_stands_as_its_day_says(certificate, expires, standing):
    assert Paper("laser tracker", "42", certificate, expires).standing(TODAY) == standing


def test_what_is_wrong_is_said_with_the_serial_number():
    expired, held = judged_papers(
        [
            Paper("laser tracker", "42", "report 7", "2026-01-31"),
            Paper("plate", "", "report 8", "2027-01-31"),
        ],
        TODAY,
    )

    said = "The certificate of the laser tracker, serial number 42 expired on 2026-01-31 (report 7)."
    assert english(expired.fault) == said
    assert held.fault == ""


def test_only_a_claim_of_calibration_passes_over_certificates():
    papers = judged_papers([Paper("laser tracker"), Paper("plate", "", "report 8", "2027-01-31")], TODAY)

    claimed = Closing(1, "calibrated", "Ada", "It was checked.", papers)
    disclaimed = Closing(1, "not calibrated", "Ada", "", papers)

    assert [one.paper.of for one in claimed.overridden] == ["laser tracker"]
    assert disclaimed.overridden == ()
