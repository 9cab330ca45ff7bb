"""What the product says is what was taken down; `make behaviour` takes down what was changed on purpose."""

import re

import pytest

from tests.helpers.web.routes import document
from tests.recorded import commands, day, wires
from tests.recorded.transcript import KEPT

_ASKED = re.compile(r"^### (\w+) ([^\s?]+)", re.MULTILINE)
# What follows something for ever, simulated cells alone have, or needs a moment that comes when it likes.
NOT_ASKED = {
    "accept_link",
    "add_configurations",
    "add_draft_file",
    "cancel_job",
    "choose_secrets",
    "correct_draft",
    "diagnose_session",
    "end_fault",
    "follow_events",
    "follow_session",
    "get_metrics",
    "get_sphere",
    "give_fault",
    "make_campaign_of_draft",
    "plan_session_again",
    "remove_draft_file",
    "switch_person",
    "use_hands",
}


def same(transcripts):
    """Hold transcripts against what is kept."""
    return [line for transcript in transcripts for line in transcript.changes()]


@pytest.mark.parametrize("spend", day.DAYS, ids=lambda spend: spend.__name__)
async def test_a_day_at_the_cell_goes_as_it_went(spend, tmp_path, empty_pictures):
    assert same(await spend(tmp_path)) == []


def test_commands_print_what_they_printed(tmp_path):
    assert same([commands.type_all(tmp_path)]) == []


def test_drivers_and_devices_say_what_they_said():
    assert same(wires.listen()) == []


def test_every_operation_is_asked_on_some_day_but_for_those_named():
    asked = {
        (method, path)
        for file in KEPT.rglob("*.txt")
        for method, path in _ASKED.findall(file.read_text("utf-8"))
    }

    left = {
        operation["operationId"]
        for path, methods in document()["paths"].items()
        for method, operation in methods.items()
        if not any(verb == method.upper() and _pattern(path).fullmatch(to) for verb, to in asked)
    }

    assert left == NOT_ASKED


def _pattern(path):
    return re.compile(re.sub(r"\{.*?\}", "[^/]+", path))
