"""A plan on paper: every stop once, with the cups in their order; nothing that the plan does not ask for."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.sessions import make_ballbar_plan
from tests.helpers.domain.tracker_sessions import make_plan
from tests.helpers.web.pages import Page
from truepose.planning.prediction.errors import Discrepancy
from truepose.planning.prediction.plan import Assumptions, PromisedPlan
from truepose.reports.checklist import ChecklistReport, checklist_of
from truepose.reports.paper import PAPER
from truepose.reports.traceability import ReportConditions

TRACKER, BALLBAR = make_plan(3), make_ballbar_plan()
GRANTED = Assumptions(0.001, 0.01, Discrepancy(0.0))


def page_of(plan, **changes):
    return ChecklistReport("IRB 120", "March", checklist_of(plan), 30.0, **changes).page()


def rows_of(page):
    return re.findall(r"<tr><td><span class=\"box\">.*?</tr>", page, re.DOTALL)


def test_a_tracker_plan_lists_every_stop_with_nest_joints_and_time():
    page = page_of(TRACKER)
    rows = [Page(row).text.split() for row in rows_of(page)]

    assert [row[1] for row in rows] == [str(stop.config) for stop in TRACKER.stops]
    assert [row[0] for row in rows] == ["0", "10", "20"]
    assert all(
        f"nest {stop.nest}" in Page(row).text for stop, row in zip(TRACKER.stops, rows_of(page), strict=True)
    )
    first = f"{math.degrees(TRACKER.stops[0].joints_rad[0]):.2f}".replace("-", "\N{MINUS SIGN}")
    assert first in Page(rows_of(page)[0]).text
    assert "<svg" not in page


def test_a_camera_has_no_reflectors_to_look_after():
    camera = page_of(replace(TRACKER, measures="poses"))

    assert "The camera is on, warm" in camera
    assert "reflector" not in camera
    assert "reflector" in page_of(TRACKER)


@pytest.mark.parametrize(("camera", "first"), [(False, "check.tracker.warm"), (True, "check.camera.warm")])
def test_a_promised_plan_is_prepared_for_what_the_cell_measures_with(camera, first):
    promised = PromisedPlan(np.zeros((2, 6)), None, None, (), 2, 0, (), {}, GRANTED)

    assert checklist_of(promised, camera=camera).prepare[0] == first


def test_a_ballbar_plan_has_a_box_for_each_leg_and_a_picture_of_each_order():
    page = page_of(BALLBAR)
    poses = [pose for placement in BALLBAR.placements for pose in placement.poses]
    orders = {pose.legs for pose in poses}

    for pose, row in zip(poses, rows_of(page), strict=True):
        assert re.findall(r"B\d-T\d", row) == [f"B{base}-T{tool}" for base, tool in pose.legs]
        assert row.count('class="box"') == 1 + len(pose.legs)
    assert page.count("<svg") == len(orders)
    assert page.count("<path") == sum(map(len, orders))


def test_the_picture_joins_the_cups_that_are_connected():
    listed = checklist_of(BALLBAR)
    page = page_of(BALLBAR)
    base, tool = listed.stops[0].legs[0]
    x = {
        name: float(at)
        for at, name in re.findall(r'<text x="([\d.]+)"[^>]*>([BT]\d)<', page.split("</svg>")[0])
    }

    x1, x2 = map(float, re.search(r"M([\d.]+) 146L([\d.]+) 44", page).groups())

    assert (x1, x2) == pytest.approx((x[f"B{base}"], x[f"T{tool}"]), abs=0.1)


def test_what_is_to_be_prepared_is_of_the_instrument():
    assert "ballbar" not in page_of(TRACKER).lower().split("</style>")[1]
    assert "Placement 1 of the base fixture" in page_of(BALLBAR)


def test_a_simulated_plan_says_so():
    assert "SIMULATED" not in page_of(TRACKER)
    assert "SIMULATED" in page_of(TRACKER, conditions=ReportConditions(simulated=True))


def test_every_colour_of_a_picture_has_one_on_paper():
    assert set(re.findall(r'="var\(--([a-z-]+)\)"', page_of(BALLBAR))) <= set(PAPER)
