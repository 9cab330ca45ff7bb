"""The one next step: from what is there, whatever order it came in."""

from dataclasses import replace

import pytest

from truepose.storage.results.items import HELD_OUT, PROOF, TEST, WorkItem, WorkKind
from truepose.storage.results.lineage import Lineage
from truepose.web.pages.next_action import Ask, CellProgress, action_after, identify_and_diagnose, next_action

_DEVICES = ("tracker", "robot")


def item(kind, number, *, state="", role=""):
    return WorkItem(
        kind, number, f"2026-05-04T09:{number:02}:00", "left arm", "ABB IRB 120", "", state, role, False
    )


def session(state, role="calibration", number=7):
    return item(WorkKind.SESSION, number, state=state, role=role)


def cell(*items, connected=2, job_id=None):
    sessions = [one for one in items if one.kind is WorkKind.SESSION]
    newest = sessions[-1] if sessions else None
    return CellProgress(_DEVICES, connected, newest, Lineage(items) if items else None, job_id)


_MEASURED = session("finished")
_CAMPAIGN = item(WorkKind.CAMPAIGN, 8)
_IDENTIFIED = item(WorkKind.IDENTIFICATION, 9, state="converged")
_MODEL = item(WorkKind.MODEL, 10)
_DIAGNOSED = item(WorkKind.DIAGNOSIS, 11, state="explained")
_EXTENDED = item(WorkKind.MODEL, 12)
_VALIDATED = item(WorkKind.VALIDATION, 13, state="passed")
_CORRECTED = item(WorkKind.CORRECTION, 14)
_WAY = (_MEASURED, _CAMPAIGN, _IDENTIFIED, _MODEL, _DIAGNOSED, _EXTENDED, _VALIDATED, _CORRECTED)


def test_where_nothing_is_connected_everything_is_asked_who_it_is():
    step = next_action(cell(connected=0))

    assert step.action == "step.connect"
    assert [ask.path for ask in step.asks] == [f"/api/v1/devices/{name}/connect" for name in _DEVICES]
    assert step.leads == ""


def test_where_nothing_was_planned_a_calibration_is():
    assert (next_action(cell()).action, next_action(cell()).href) == ("step.plan", "/plan")


def test_a_cell_without_devices_plans():
    assert next_action(CellProgress()).action == "step.plan"


@pytest.mark.parametrize(("connected", "action"), [(0, "step.connect"), (1, "step.start")])
def test_what_is_planned_is_started_once_something_is_connected(connected, action):
    assert next_action(cell(session("planned"), connected=connected)).action == action


@pytest.mark.parametrize("state", ["running", "pausing", "paused", "awaiting_confirmation", "aborting"])
def test_a_session_under_way_comes_first_whatever_else_waits(state):
    step = next_action(cell(session(state), connected=0, job_id=4))

    assert (step.action, step.href) == ("step.session", "/sessions/7")


def test_a_job_under_way_is_watched():
    assert next_action(cell(_MEASURED, job_id=4)).href == "/jobs/4"


def test_finished_readings_are_identified_by_one_tap():
    step = next_action(cell(_MEASURED, connected=0))

    assert step.asks == (
        Ask("/api/v1/sessions/7/campaign", {"name": "left arm"}),
        Ask("/api/v1/identifications", takes="campaign_id"),
    )
    assert step.leads == "/identifications"


@pytest.mark.parametrize(
    ("made", "action"),
    [
        (2, "step.identify"),
        (4, "step.diagnose"),
        (6, "step.validate"),
        (7, "step.correct"),
        (8, "step.prove"),
    ],
)
def test_each_result_leads_to_the_next(made, action):
    assert action_after(Lineage(_WAY[:made])).action == action


def test_an_identified_model_is_diagnosed_by_one_tap():
    step = action_after(Lineage(_WAY[:4]))

    assert step.asks == (Ask("/api/v1/diagnoses", {"campaign_id": 8, "keep_set_aside": True}),)
    assert step.leads == "/diagnoses"


def test_a_model_is_validated_on_readings_that_it_never_saw_with_a_limit_of_the_readers_choice():
    held_out = replace(_CAMPAIGN, role=HELD_OUT)

    step = action_after(Lineage((_MEASURED, held_out, *_WAY[2:6])))

    assert step.asks == (Ask("/api/v1/validations", {"model_id": 12, "campaign_id": 8}),)
    assert (step.leads, step.is_limited) == ("/validations", True)
    assert step.beside.href == "/corrections?model_id=12"


@pytest.mark.parametrize("made", [(_CAMPAIGN, _IDENTIFIED, _MODEL, _DIAGNOSED, _EXTENDED), (_MODEL,)])
def test_without_readings_that_judge_a_test_is_planned(made):
    step = action_after(Lineage(made))

    assert (step.action, step.href, step.asks) == ("step.validate", "/sessions/new#iso9283", ())


def test_what_judged_an_older_model_does_not_judge_the_newest():
    judged_before = (_CAMPAIGN, _IDENTIFIED, _MODEL, replace(_VALIDATED, recorded_at=_MODEL.recorded_at))

    assert action_after(Lineage((*judged_before, _DIAGNOSED, _EXTENDED))).action == "step.validate"


@pytest.mark.parametrize(
    ("state", "action", "why"),
    [
        ("passed", "step.correct", "step.correct.why"),
        ("no_limit", "step.correct", "step.correct.why"),
        ("failed", "step.plan", "step.not_passed.why"),
        ("worse", "step.plan", "step.not_passed.why"),
        ("undecided", "step.validate", "step.undecided.why"),
    ],
)
def test_only_a_model_that_was_not_refused_leads_to_a_correction(state, action, why):
    step = action_after(Lineage((*_WAY[:6], replace(_VALIDATED, state=state))))

    assert (step.action, step.why.key) == (action, why)


def test_identify_and_diagnose_makes_both_of_one_campaign():
    step = identify_and_diagnose(7, "left arm")

    assert [(ask.path, ask.takes) for ask in step.asks] == [
        ("/api/v1/sessions/7/campaign", ""),
        ("/api/v1/identifications", "campaign_id"),
        ("/api/v1/diagnoses", "campaign_id"),
    ]
    assert [ask.body for ask in step.asks[1:]] == [{"keep_set_aside": True}] * 2


def test_a_correction_is_proved_with_its_own_model():
    assert action_after(Lineage(_WAY)).href == "/sessions/new?model_id=12#prove"


@pytest.mark.parametrize(
    ("state", "action"),
    [("planned", "step.start"), ("running", "step.session"), ("finished", "step.report")],
)
def test_a_proof_is_measured_and_then_shown(state, action):
    proof = session(state, PROOF, number=15)

    assert action_after(Lineage((*_WAY, proof))).action == action


def test_readings_of_which_no_model_could_be_made_lead_to_a_new_plan():
    refused = item(WorkKind.IDENTIFICATION, 9, state="not identifiable")

    assert action_after(Lineage((_MEASURED, _CAMPAIGN, refused))).action == "step.plan"


@pytest.mark.parametrize("role", ["validation", TEST])
def test_a_test_leads_to_its_result(role):
    assert action_after(Lineage((session("finished", role),))).href == "/sessions/7/result"


@pytest.mark.parametrize("state", ["aborted", "failed"])
def test_nothing_follows_from_readings_that_were_given_up(state):
    assert action_after(Lineage((session(state),))) is None


def test_a_session_that_was_given_up_is_planned_again():
    assert next_action(cell(session("aborted"))).action == "step.plan"


def test_nothing_follows_from_a_proof_that_was_given_up():
    assert action_after(Lineage((*_WAY, session("aborted", PROOF, number=15)))) is None
