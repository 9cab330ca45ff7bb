"""What a report says of certified lengths: at 20 °C, and at the temperature of the day where known."""

from dataclasses import replace

import pytest

from truepose.domain.cell import length_at
from truepose.messages.catalogue import IN_ENGLISH
from truepose.reports.traceability import LengthOfDay, ReportConditions, condition_rows, length_sentence

STEEL = LengthOfDay("calibrator", 300.0012, 0.0004, 1.15e-5, (21.0, 23.0))


def told(length):
    return IN_ENGLISH.spoken(length_sentence(length))


@pytest.mark.parametrize(("celsius", "length_mm"), [(20.0, 300.0), (22.0, 300.0069), (18.0, 299.9931)])
def test_steel_grows_from_20_degrees_on(celsius, length_mm):
    assert length_at(300.0, 1.15e-5, celsius) == pytest.approx(length_mm, abs=1e-9)


def test_the_length_of_the_day_stands_beside_the_certified_one():
    assert told(STEEL) == (
        "300.00120 mm at 20 °C (u 0.00040 mm); 300.00465 to 300.01155 mm at the measured 21.0 to 23.0 °C. "
        "The readings use its length at 20 °C, which differs by up to 0.0104 mm"
    )


def test_what_is_not_known_is_not_computed():
    unread, unknown = (told(replace(STEEL, **{name: None})) for name in ("temperature_c", "expansion_per_k"))

    assert unread.endswith("no temperature was recorded while it was in use")
    assert unknown.endswith("because its expansion coefficient is not stated")


def test_conditions_state_temperatures_of_air_ballbar_and_part():
    silent = dict(condition_rows(ReportConditions()))
    stated = dict(
        condition_rows(
            ReportConditions(instrument_temperature_c=(21.0, 22.0), part_temperature_c=21.4, lengths=(STEEL,))
        )
    )

    assert silent["Temperature of arm and artefact"] == "not stated"
    assert "Temperature at the ballbar" not in silent
    assert stated["Temperature of arm and artefact"] == "21.4 °C"
    assert stated["Temperature at the ballbar"] == "21.0 to 22.0 °C"
    assert stated["Certified length: calibrator"].startswith("300.00120 mm at 20 °C")
