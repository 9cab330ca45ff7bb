"""What each look at the service means, and which of them a person is told first."""

import pytest

from truepose.health import Clock, Copies, DeviceLink, Records, State
from truepose.messages.catalogue import LANGUAGES, catalogue, english
from truepose.web.api.health_checks import checks, worst

GIB = 2**30
WELL = Records(commit_s=0.003, free_bytes=50 * GIB, integrity="whole", links=12)
DAY_S = 86400.0


def state(**differing):
    return State(**{"simulated": True, "records": WELL, "devices": {"robot": DeviceLink(True)}} | differing)


def records(**differing):
    fields = {name: getattr(WELL, name) for name in WELL.__slots__}
    return state(records=Records(**fields | differing))


def verdicts(found):
    return {check.name: check.verdict for check in checks(found) if check.verdict != "ok"}


def test_nothing_is_said_of_a_service_that_is_well():
    assert verdicts(state()) == {}
    assert worst(checks(state())) == "ok"


AMISS = {
    "unreadable": (records(readable=False), {"database": "bad"}, "cannot be read"),
    "late": (records(late=True), {"database": "warn"}, "did not respond within a second"),
    "a late server": (records(late=True, server_doubts=()), {"database": "warn"}, "server did not respond"),
    "refused": (
        records(refused="The disk is full."),
        {"database": "bad"},
        "The disk is full. Measurements are",
    ),
    "silent": (records(commit_s=None), {"database": "warn"}, "within a second"),
    "a network's disk": (records(commit_s=0.17), {"database": "warn"}, "take 170 ms"),
    "a failing disk": (records(commit_s=2.0), {"database": "bad"}, "take 2000 ms"),
    "little room": (records(free_bytes=GIB), {"disk": "warn"}, "Only 1.1 GB"),
    "no room": (records(free_bytes=GIB // 20), {"disk": "bad"}, "Free up space now"),
    "the reserve": (records(reserve_used=True, free_bytes=0), {"disk": "bad"}, "16 MB reserve"),
    "damage": (records(damage="Record 3 is gone."), {"chain": "bad"}, "Record 3 is gone. Stop measuring"),
    "a look that was not finished": (
        records(integrity="not_checked", unchecked="no memory"),
        {"chain": "warn"},
        "could not be checked (no memory)",
    ),
    "no copies of a real cell": (state(simulated=False), {"backup": "warn"}, "Backups are off"),
    "no copy yet": (state(copies=Copies(DAY_S)), {"backup": "warn"}, "No backup yet"),
    "an old copy": (state(copies=Copies(DAY_S, 3 * DAY_S)), {"backup": "bad"}, "72 h old"),
    "a copy that failed": (state(copies=Copies(DAY_S, 1.0, "No room.")), {"backup": "bad"}, "No room."),
    "a device": (state(devices={"robot": DeviceLink(fault="No answer.")}), {"devices": "warn"}, "robot: No"),
    "another device": (
        state(devices={"robot": DeviceLink(True, foreign=True)}),
        {"devices": "warn"},
        "not the one specified",
    ),
    "many jobs": (state(jobs={"queued": 21, "running": 1}), {"workers": "warn"}, "waiting: 21"),
    "a clock that was set": (state(clock=Clock(3600.0)), {"clock": "warn"}, "changed by +3600 s"),
    "a clock that is behind": (state(clock=Clock(0.0, -7200.0)), {"clock": "bad"}, "7200 s in the future"),
    "expired": (state(certificates={"tool": -1, "world": 5}), {"certificates": "bad"}, "Expired: tool."),
    "expires soon": (state(certificates={"tool": 12, "world": 5}), {"certificates": "warn"}, "within 5 days"),
    "no end said": (
        state(simulated=False, uncertified=("tool",), copies=Copies(DAY_S, 1.0)),
        {"certificates": "warn"},
        "No expiry date",
    ),
    "lines lost": (state(lines_lost=3), {"log": "warn"}, "3 log lines"),
}


@pytest.mark.parametrize(("found", "expected", "words"), AMISS.values(), ids=AMISS.keys())
def test_what_is_amiss_is_said_and_weighed(found, expected, words):
    assert verdicts(found) == expected
    told = [english(check.sentence) for check in checks(found) if check.name in expected]
    assert words in told[0]
    assert worst(checks(found)) in expected.values()


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_sentence_is_said_in_every_language(language):
    words = catalogue(language)

    for found, _, _ in [(state(), None, None), *AMISS.values()]:
        for check in checks(found):
            assert not words.spoken(check.sentence).startswith("health."), check
            assert words.say(f"health.name.{check.name}") != f"health.name.{check.name}"


@pytest.mark.parametrize("age_s", [0.0, DAY_S, 1.9 * DAY_S])
def test_a_copy_that_is_a_little_late_is_no_alarm(age_s):
    assert verdicts(state(copies=Copies(DAY_S, age_s))) == {}
