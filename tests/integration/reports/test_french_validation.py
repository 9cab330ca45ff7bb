"""A validation is told in French throughout: its report with a test of ISO 9283, and its tables."""

import io
import re

import numpy as np
import pytest
from rich.console import Console

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of
from tests.helpers.identification.synthetic import NESTS, configurations
from tests.helpers.web.pages import Page
from tests.helpers.words.english import english_in
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.identification import NestCentre
from truepose.domain.robot import FramePlacement
from truepose.identification.model.validity import measured_zone
from truepose.kinematics.chain import nominal_chain
from truepose.messages.catalogue import catalogue
from truepose.reports.pose_test import pose_test_summary
from truepose.reports.traceability import ReportConditions
from truepose.reports.validation import ValidationReport, validation_summary
from truepose.validation.iso9283.plan import Cube, plan_poses
from truepose.validation.iso9283.pose_test import pose_test
from truepose.validation.validate import validate

FRENCH = catalogue("fr")
_CENTRES = tuple(NestCentre(number, centre) for number, centre in enumerate(NESTS, start=1))
_PLACED = {"base": FramePlacement(), "nests": _CENTRES, "nominal_nests": _CENTRES}
MODEL = model_of(
    IRB_120,
    nominal_base=FramePlacement(x_mm=1.0),
    zone=measured_zone(IRB_120, configurations(50)),
    discrepancy_mm=0.03,
    **_PLACED,
)
PLAN = plan_poses(IRB_120, Cube((300.0, 0.0, 250.0), 150.0), np.diag([1.0, -1.0, -1.0]), NESTS[0])


@pytest.fixture(scope="module")
def points():
    """Thirty cycles, of which one visit of P3 was lost, and twenty other configurations."""
    stops = [stop for stop in PLAN.session(nest=1).stops if stop.config != 13]
    joints = np.vstack([[stop.joints_rad for stop in stops], configurations(20, seed=4)])
    repeat_of = [-1 if stop.repeat_of is None else stop.repeat_of for stop in stops] + [-1] * 20
    config = [stop.config for stop in stops] + list(range(201, 221))
    places = nominal_chain(IRB_120, joints).points(np.array(NESTS[0]))
    seen = places + np.array([0.03, 0.0, 0.04])
    known = Stops(np.array(config), joints, repeat_of=np.array(repeat_of))
    return PointReadings(known, np.ones(len(joints), dtype=np.int64), seen, np.full(len(joints), 0.002))


def text_of(path, points, language="fr", limit_mm=None, test=None):
    found = validate(MODEL, points, limit_mm=limit_mm)
    conditions = ReportConditions(load="2.6 kg")
    report = ValidationReport(found, MODEL, points, pose_test=test, conditions=conditions, language=language)
    report.write(path)
    return Page(re.sub("<style.*?</style>", "", path.read_text("utf-8"), flags=re.DOTALL)).text


def printed(*tables):
    console = Console(file=io.StringIO(), width=300)
    console.print(*tables)
    return console.file.getvalue()


def test_a_report_with_a_test_of_iso_9283_is_french_throughout(tmp_path, points):
    text = text_of(tmp_path / "report.html", points, limit_mm=0.2, test=pose_test(MODEL, points))

    assert "Avec une bande de garde de" in text
    assert "exactitude de pose" in text
    assert "avant/haut" in text
    assert english_in(text) == []


@pytest.mark.usefixtures("empty_pictures")
def test_the_same_report_in_english_is_seen(tmp_path, points):
    text = text_of(tmp_path / "report.html", points, "en", limit_mm=0.2, test=pose_test(MODEL, points))

    assert {"the", "of", "with"} <= set(english_in(text))


@pytest.mark.parametrize(
    ("limit_mm", "rule", "told"),
    [
        (None, "guard band", "conforme \u00e0 l\u2019exactitude pr\u00e9vue"),
        (0.2, "guard band", "(ISO 14253-1, 95\u00a0%), il est conforme"),
        (0.01, "guard band", "il n\u2019est pas conforme"),
        (0.051, "guard band", "on ne peut d\u00e9cider"),
        (0.2, "simple", "Par acceptation simple, il est conforme"),
        (0.01, "simple", "Par acceptation simple, il n\u2019est pas conforme"),
    ],
)
def test_every_verdict_is_told_in_french(points, limit_mm, rule, told):
    text = printed(validation_summary(validate(MODEL, points, limit_mm=limit_mm, rule=rule), FRENCH))

    assert told in text
    assert english_in(text) == []


def test_a_table_of_iso_9283_speaks_french_too(points):
    text = printed(pose_test_summary(pose_test(MODEL, points), FRENCH))

    assert "Non donn\u00e9\u00a0:" in text
    assert "Command\u00e9 par" in text
    assert english_in(text) == []
