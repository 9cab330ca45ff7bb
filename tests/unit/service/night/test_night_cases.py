"""What the cases of a night say of what they see, right and wrong."""

import numpy as np
import pytest

from truepose.demo import client
from truepose.demo.client import attend
from truepose.demo.errors import SessionHaltedError
from truepose.exchange.cells.file import scenario_text
from truepose.night.faulty_sessions import FaultySession, _checks, _Lives
from truepose.night.nightly import night_cases
from truepose_simulators.scenarios.file import load_scenario


class Session:
    """A service with one session, which goes through given documents while it is looked at."""

    def __init__(self, *shown, readings=()):
        self._shown = list(shown)
        self._readings = list(readings)
        self.acts = []

    async def get(self, path):
        return self._shown.pop(0) if len(self._shown) > 1 else self._shown[0]

    async def readings(self, session_id):
        return self._readings.pop(0) if len(self._readings) > 1 else self._readings[0]

    async def begin(self, session_id):
        self.acts.append("begin")

    async def resume(self, session_id):
        self.acts.append("resume")

    async def confirm(self, session_id):
        self.acts.append("confirm")


def shown(state, measured=0, **more):
    return {
        "id": 1,
        "state": state,
        "reason": "because",
        "measured": measured,
        "skipped": 0,
        "planned": 3,
    } | more


def reading(number, config=1, **more):
    told = {"id": number, "nest": 1, "point": {"config": config}, "superseded_by": None}
    return told | more


@pytest.fixture(autouse=True)
def _no_waiting(monkeypatch):
    monkeypatch.setattr(client, "_LOOK_S", 0.0)
    monkeypatch.setattr("truepose.night.faulty_sessions._STILL_S", 0.0)


async def test_somebody_confirms_and_resumes_until_it_is_finished():
    session = Session(
        shown("awaiting_confirmation"), shown("running"), shown("paused"), shown("finished", measured=3)
    )

    seen = await attend(session, 1)

    assert session.acts == ["confirm", "resume"]
    assert (seen.finished, seen.reasons) == (True, ["because", "because"])


async def test_nothing_is_done_to_a_session_that_runs():
    session = Session(shown("running"), shown("running", measured=2))

    assert not (await attend(session, 1, lambda measured: measured > 1)).finished
    assert session.acts == []


async def test_a_session_that_fails_or_stands_for_ever_is_an_error_with_its_reason():
    with pytest.raises(SessionHaltedError, match="failed: because"):
        await attend(Session(shown("failed")), 1)
    with pytest.raises(SessionHaltedError, match="paused: because"):
        await attend(Session(shown("paused")), 1)


def lives(tmp_path):
    return _Lives(1, tmp_path)


async def judged(tmp_path, known, later, state="awaiting_confirmation"):
    """What is said of a session that had readings before a kill, and others after it."""
    seen = lives(tmp_path)
    await seen.work(
        Session(shown("planned"), shown("running", measured=3), readings=[[], [], known]), 1, 2, 0.0
    )
    last = Session(shown(state), shown("finished", measured=3), readings=later)
    await seen.finish(last, 1)
    return {check.figure: check for check in seen.checks()}


async def test_where_everything_is_there_again_nothing_is_said(tmp_path):
    both = [reading(1), reading(2, config=2)]

    assert all(check.passed for check in (await judged(tmp_path, both[:1], [both])).values())


async def test_a_reading_that_is_lost_or_changed_is_named(tmp_path):
    known = [reading(1), reading(2, config=2)]

    lost = await judged(tmp_path, known, [known[:1]])
    changed = await judged(tmp_path, known, [[reading(1, nest=2), known[1]]])

    assert "reading 2" in lost["acknowledged readings lost or changed"].measured
    assert "reading 1" in changed["acknowledged readings lost or changed"].measured


async def test_a_configuration_measured_twice_is_named_unless_the_later_counts(tmp_path):
    twice = [reading(1, config=7), reading(2, config=7)]
    again = [reading(1, config=7, superseded_by=2), reading(2, config=7)]

    assert (
        "configuration 7" in (await judged(tmp_path, [], [twice]))["configurations measured twice"].measured
    )
    assert (await judged(tmp_path, [], [again]))["configurations measured twice"].passed


async def test_a_service_that_goes_on_by_itself_is_named(tmp_path):
    figure = "restarts followed by unrequested motion"
    one, two = [reading(1)], [reading(1), reading(2, config=2)]

    assert not (await judged(tmp_path, one, [one], state="running"))[figure].passed
    assert not (await judged(tmp_path, one, [one, two]))[figure].passed


def test_a_night_has_every_kind_of_case_under_names_of_their_own():
    names = [case.name for case in night_cases(1)]

    assert len(set(names)) == len(names)
    assert {"irb120-tilted", "killed-service"} <= set(names)


def test_other_nights_draw_other_faults_on_the_same_cells():
    one, other = night_cases(1), night_cases(2)

    assert one[0] == other[0]
    assert one != other


def a_reading(config, **more):
    return {"point": {"config": config}, "superseded_by": None} | more


def faulty(configurations, skipped=(), errors_mm=(0.01,), finished=True):
    """What is said of a faulty session of three configurations."""
    seen = client.Attendance(["because"], shown("finished" if finished else "paused"))
    session = {"planned": 3, "skipped_stops": [{"config": n, "reason": why} for n, why in skipped]}
    readings = [a_reading(config) for config in configurations]
    return {check.figure: check for check in _checks(seen, session, readings, np.array(errors_mm))}


def test_a_faulty_session_that_ends_with_true_readings_passes():
    found = faulty([1, 3], skipped=[(2, "the beam was broken")])

    assert all(check.passed for check in found.values())
    assert "operator prompted 1 times" in found["session"].measured


@pytest.mark.parametrize(
    ("figure", "session"),
    [
        ("configurations neither measured nor skipped", faulty([1, 3])),
        ("configurations measured twice", faulty([1, 2, 2, 3])),
        ("configurations skipped without a reason", faulty([1, 3], skipped=[(2, "")])),
        ("largest error of an accepted reading", faulty([1, 2, 3], errors_mm=(0.01, 0.4))),
        ("session", faulty([1, 2, 3], finished=False)),
    ],
)
def test_what_is_wrong_of_a_faulty_session_is_said_and_nothing_else(figure, session):
    assert [name for name, check in session.items() if not check.passed] == [figure]


@pytest.mark.parametrize("seed", range(4))
def test_the_faults_of_a_night_are_a_scenario(seed, tmp_path):
    case = FaultySession("lrmate-fanuc", seed)
    file = tmp_path / "lrmate-fanuc-faulty.toml"
    file.write_text(scenario_text(case.scenario, "fault", case.faults()), encoding="utf-8")

    at = [fault.configuration for fault in load_scenario(str(file)).faults]

    assert at == sorted(set(at))
    assert at == [fault["configuration"] for fault in case.faults()]
    assert FaultySession("lrmate-fanuc", seed + 1).faults() != case.faults()
