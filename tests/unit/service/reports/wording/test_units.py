"""The same report in inches, radians and °F: the numbers of the result, converted, and no other."""

import re

import numpy as np
import pytest

from tests.helpers.web.pages import Page
from truepose.exchange.results.identification import identification_document
from truepose.messages.catalogue import catalogue
from truepose.reports.identification.report import IdentificationReport
from truepose.reports.rounding import millimetres

MM_PER_IN = 25.4
KEPT_UNIT = re.compile(r"(?<![\w/])(?:mm|.m|deg|°C)(?![\w/])")


@pytest.fixture(scope="module")
def page(identification, campaign):
    return Page(IdentificationReport(identification, campaign, language="en-x-inch-rad-f").page())


def test_the_report_states_its_units_and_uses_no_other(page):
    assert "in, rad, °F" in page.text
    assert KEPT_UNIT.findall(page.text) == []


def test_its_numbers_are_those_of_the_document_in_inches(page, identification, campaign):
    stated = identification_document(identification, campaign.robot.name)["statistics"]["validation"][
        "identified"
    ]

    for name in ("mean_mm", "rms_mm", "sd_mm", "max_mm"):
        shown = catalogue("en-x-inch").units.printed(millimetres(stated[name]))
        assert shown in page.text, name
        assert float(shown) * MM_PER_IN == pytest.approx(stated[name], abs=0.5e-4)


def test_what_is_a_ratio_stays(page, identification):
    pair = identification.validation
    assert f"{pair.nominal.mean_mm / pair.identified.mean_mm:.2g} times" in page.text
    assert f"120 observations in {len(np.unique(np.arange(40)))} configurations" in page.text
