"""The DH-Modified table of a model, as CSV and as text."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import SEVEN_AXES
from tests.helpers.identification.models import model_of, parameters_of
from truepose.exchange.models.exports import export

MODEL = model_of(
    SEVEN_AXES,
    *parameters_of("geometry", [("a_3", 0.25, "mm"), ("theta_2", 1e-3, "rad")]),
    *parameters_of("axis_parallelism", [("beta_4", 2e-3, "rad")]),
    covariance=np.diag([0.04, 1e-4, 1e-5]) ** 2,
)


def rows():
    return list(csv.DictReader(io.StringIO(export(MODEL, "dhm", as_csv=True).text)))


def test_a_row_has_values_uncertainties_and_nominal_values_in_documents_units():
    second, third, fourth = rows()[1:4]

    assert float(third["a_mm"]) == 20.25
    assert (float(third["u_a_mm"]), float(third["nominal_a_mm"])) == (0.04, 20.0)
    assert float(second["theta_offset_deg"]) == pytest.approx(10.0 + np.rad2deg(1e-3), abs=1e-12)
    assert float(second["u_theta_offset_deg"]) == pytest.approx(np.rad2deg(1e-4))
    assert float(fourth["beta_deg"]) == pytest.approx(np.rad2deg(2e-3))
    assert [row["sign"] for row in rows()] == ["1", "-1", "1", "1", "-1", "1", "1"]


def test_what_no_parameter_moves_has_no_uncertainty():
    assert rows()[0]["u_a_mm"] == rows()[2]["u_d_mm"] == ""


def test_the_text_lines_its_columns_up_and_says_base_and_nests():
    lines = export(MODEL, "dhm").text.splitlines()

    head = next(k for k, line in enumerate(lines) if line.startswith("joint"))
    assert len({len(line) for line in lines[head : head + 8]}) == 1
    assert "20.2500  0.0400" in lines[head + 3]
    assert any(line.startswith("base in the frame of the readings: x 100.0000 mm") for line in lines)
    assert any(line.startswith("nest 2: x 75.0000 mm") for line in lines)


def test_a_table_without_parameters_is_the_nominal_one():
    nominal = rows_of(replace(MODEL, parameters=(), effects=(), covariance=np.zeros((0, 0))))

    assert all(row["a_mm"] == row["nominal_a_mm"] and not row["u_a_mm"] for row in nominal)


def rows_of(model):
    return list(csv.DictReader(io.StringIO(export(model, "dhm", as_csv=True).text)))
