"""A robot compared on a small recorded session, and how outcomes become rows."""

import json
import math
from dataclasses import asdict, replace

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, fixture_before_the_arm
from tests.studies.ballbar_report.document import ballbar_document
from tests.studies.ballbar_report.plans import PlanKind, made_plan, plan_document, plan_path
from tests.studies.ballbar_report.robot_sections import robot_sections, stated_section
from tests.studies.ballbar_report.robots import Outcome, Stated, TrueError, compared
from tests.studies.ballbar_report.session import record_session, without_noise
from tests.studies.ballbar_report.work import Extent, robots_of
from tests.studies.diagnosis_report.recorder import running_recorder
from truepose.domain.ballbar import BallbarPlan
from truepose.planning.ballbar.plan import plan_at
from truepose.reports.table_report import Verdict
from truepose_simulators.recording.ballbars.plan import plan_from


@pytest.fixture(scope="module")
def plan():
    return plan_at(ballbar_cell(), [fixture_before_the_arm()], 24)


@pytest.fixture(scope="module")
def session(plan, tmp_path_factory):
    folder = tmp_path_factory.mktemp("session")
    path = folder / "plan.json"
    path.write_text(json.dumps(plan_document(plan)), encoding="utf-8")
    with running_recorder() as recorder:
        return record_session(recorder, "lrmate-tilted", 2, path, folder / "campaign", 40)


@pytest.fixture(scope="module")
def outcome(session):
    return compared(Outcome("lrmate-tilted", "one", 2), session, coverage=True)


def test_a_plan_is_written_as_the_recorder_reads_it(plan):
    read = plan_from(json.loads(json.dumps(plan_document(plan))), "plan")

    (planned,), (placement,) = plan.placements, read.placements
    assert len(placement.poses) == len(planned.poses) == 24
    assert placement.poses[3].legs == planned.poses[3].legs
    assert np.radians(placement.poses[3].joints_deg) == pytest.approx(planned.poses[3].joints_rad)
    assert len(placement.cups_mm) == 3


def test_a_plan_that_is_there_is_not_made_again(tmp_path):
    kind = PlanKind("one", "one placement", 1, 3)
    plan_path(kind, tmp_path).write_text(json.dumps(plan_document(BallbarPlan(()))), encoding="utf-8")

    assert json.loads(made_plan(kind, tmp_path).read_text(encoding="utf-8")) == {"placements": []}


def test_the_ballbar_and_the_tracker_find_the_same_robot(outcome):
    # nominal robots are 1 mm off and more; 40 positions of a tilted robot are left with hundredths
    assert outcome.ballbar.tied_mm < 0.1
    assert outcome.tracker.tied_mm < 0.1
    assert outcome.ballbar.aligned_mm <= 1.01 * outcome.ballbar.tied_mm


def test_cups_that_were_elsewhere_count_as_an_error_of_the_tie(session, outcome):
    moved = {cup: place + np.array([0.0, 0.0, 0.5]) for cup, place in session.cups_mm.items()}

    off = compared(Outcome("lrmate-tilted", "one", 2), replace(session, cups_mm=moved))

    assert off.ballbar.tied_mm == pytest.approx(0.5, abs=2 * outcome.ballbar.tied_mm)
    assert off.ballbar.aligned_mm == pytest.approx(outcome.ballbar.aligned_mm)
    assert off.tracker == outcome.tracker


def test_exact_lengths_are_those_between_true_cups_and_nests(session):
    exact = without_noise(session)

    assert exact.legs.length_mm == pytest.approx(session.ballbar.legs.length_mm, abs=0.05)  # scatter and zero
    assert np.any(exact.legs.length_mm != session.ballbar.legs.length_mm)
    assert exact.fixture.length_mm == pytest.approx(session.ballbar.fixture.length_mm, abs=0.01)


def test_parameters_are_off_by_about_what_they_state(outcome):
    scores = np.array(outcome.stated.scores)

    assert len(scores) > 25
    # of 25 and more scores, correlated ones among them; an uncertainty twice too small or large shows
    assert 0.3 < np.sqrt(np.mean(scores**2)) < 2.0


def test_a_robot_without_a_side_of_its_triangle_has_no_procedure_of_the_thesis(session):
    fixture = session.ballbar.fixture
    keep = np.flatnonzero(~((fixture.placement == 1) & (fixture.point_b == 2)))
    open_triangle = replace(fixture, **{name: getattr(fixture, name)[keep] for name in asdict(fixture)})

    found = compared(
        Outcome("lrmate-tilted", "one", 2),
        replace(session, ballbar=replace(session.ballbar, fixture=open_triangle)),
    )

    assert found.thesis is None
    assert "Side 1-2" in found.no_thesis
    assert found.ballbar is not None


def row(sections, part):
    (found,) = (one for section in sections for one in section.rows if part == one.figure)
    return found


def made(ballbar=0.4, thesis=2.0, **changes):
    errors = {"ballbar": TrueError(ballbar, 0.3), "tracker": TrueError(1.0, 0.9)}
    thesis = None if thesis is None else TrueError(thesis, 1.0)
    return Outcome("lrmate-tilted", "one", 1, 60, **(errors | {"thesis": thesis} | changes))


def test_the_tied_error_has_the_target_and_the_aligned_one_stands_beside_it():
    sections = robot_sections([made(), made(ballbar=0.6)])

    tied = row(sections, "one placement: ballbar over tracker")
    assert (tied.target, tied.verdict) == ("<= 0.60", Verdict.PASSED)
    assert tied.measured.startswith("0.500 ± 0.100")
    assert row(sections, "one placement: ballbar over tracker, aligned").verdict is Verdict.NO_TARGET
    assert row(sections, "one placement: ballbar over thesis").verdict is Verdict.PASSED


def test_robots_without_the_thesis_are_counted_and_do_not_enter_its_ratio():
    sections = robot_sections([made(), made(thesis=None, no_thesis="Side 1-2 was not measured.")])

    assert row(sections, "one placement: without the thesis' procedure").measured.startswith("1 of 2 robots")
    assert "1 robots" in row(sections, "one placement: ballbar over thesis").measured


def test_a_session_that_gave_nothing_fails_the_report_and_says_why():
    sections = robot_sections([made(), Outcome("lrmate-tilted", "one", 7, fault="KeyError: 3")])

    broken = row(sections, "sessions that gave no figures")
    assert broken.verdict is Verdict.FAILED
    assert "one, seed 7: KeyError: 3" in broken.measured


def test_stated_uncertainties_are_pooled_over_robots():
    stated = [Stated((1.0, -3.0), 0.003, 0.5, 0.006), Stated((0.0, 2.0), 0.003, 0.5, 0.006)]

    section = stated_section([made(stated=one) for one in stated])

    assert "RMS 1.87; 50.0 % within 1.96 (4 parameters of 2 robots)" in section.rows[0].measured


def test_every_robot_is_measured_in_every_kind_of_session(tmp_path):
    robots = robots_of(Extent(robots=2, first_seed=5), tmp_path)

    assert len({(one.scenario, one.kind, one.seed) for one in robots}) == len(robots) == 2 * 3 * 2
    assert {one.seed for one in robots} == {5, 6}


def test_the_document_has_no_number_that_json_lacks():
    document = ballbar_document(Extent(), [], [made(stated=Stated((math.nan,), 0.1, 0.1, 0.1))], None)

    assert json.loads(json.dumps(document, allow_nan=False))["robots"][0]["stated"]["scores"] == [None]
