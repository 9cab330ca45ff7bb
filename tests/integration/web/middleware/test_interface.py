"""What programs rely on stays: the interface of the last release is held against the one of today."""

import copy
import functools
import json

import pytest

from tests.helpers.checkout import CHECKOUT
from tests.helpers.web.interface import broken, interface_of
from tests.helpers.web.routes import document

KEPT = json.loads((CHECKOUT / "docs" / "interface.json").read_text())
HOW = (
    "Programs rely on that. Keep it beside the new one; or, where it is meant and a major version says so in "
    "CHANGELOG.md, accept it: make interface-accepted."
)


def test_nothing_that_programs_rely_on_is_broken():
    found = broken(KEPT, interface_of(document()))

    assert not found, "\n".join([*found, HOW])


# What is changed below, and whatever it refers to.
PATHS = ["/api/v1/jobs", "/api/v1/jobs/{id}", "/api/v1/sessions"]
SCHEMAS = ["JobReply", "JobState", "ContactSessionRequest", "Problem"]


def part(copied):
    """Return a part of the document, in which some parts are copied."""
    paths = {path: copied(document()["paths"][path]) for path in PATHS}
    schemas = document()["components"]["schemas"]
    return {
        "paths": paths,
        "components": {"schemas": schemas | {one: copied(schemas[one]) for one in SCHEMAS}},
    }


@functools.cache
def before():
    return interface_of(part(lambda one: one))


def changed(change):
    copied = part(copy.deepcopy)
    change(copied["paths"], copied["components"]["schemas"])
    return broken(before(), interface_of(copied))


def removed(paths, schemas):
    del paths["/api/v1/jobs"]["get"]


def renamed(paths, schemas):
    paths["/api/v1/jobs"]["get"]["operationId"] = "list_all_jobs"


def moved(paths, schemas):
    paths["/api/v1/work"] = paths.pop("/api/v1/jobs")


def answers_less(paths, schemas):
    del schemas["JobReply"]["properties"]["message"]


def answers_null(paths, schemas):
    field = schemas["JobReply"]["properties"]["message"]
    schemas["JobReply"]["properties"]["message"] = {"anyOf": [field, {"type": "null"}]}


def answers_in_words(paths, schemas):
    schemas["JobReply"]["properties"]["fraction"] = {"type": "string"}


def refusal_without_a_sentence(paths, schemas):
    del schemas["Problem"]["properties"]["detail"]


def forgets_the_total(paths, schemas):
    del paths["/api/v1/jobs"]["get"]["responses"]["200"]["headers"]["Total-Count"]


def takes_less(paths, schemas):
    del schemas["ContactSessionRequest"]["properties"]["seed"]


def takes_fewer(paths, schemas):
    schemas["ContactSessionRequest"]["properties"]["stops"]["maximum"] = 100


def takes_no_validation(paths, schemas):
    schemas["ContactSessionRequest"]["properties"]["role"]["enum"].remove("validation")


def takes_for_granted(paths, schemas):
    schemas["ContactSessionRequest"]["properties"]["seed"]["default"] = 1


def wants_more(paths, schemas):
    schemas["ContactSessionRequest"]["required"].append("nest")


def wants_something_new(paths, schemas):
    schemas["ContactSessionRequest"]["properties"]["gauge"] = {"type": "string"}
    schemas["ContactSessionRequest"]["required"].append("gauge")


def pages_of_a_hundred(paths, schemas):
    limit = next(one for one in paths["/api/v1/jobs"]["get"]["parameters"] if one["name"] == "limit")
    limit["schema"]["maximum"] = 100


def no_pages(paths, schemas):
    paths["/api/v1/jobs"]["get"]["parameters"] = []


def needs_a_limit(paths, schemas):
    limit = next(one for one in paths["/api/v1/jobs"]["get"]["parameters"] if one["name"] == "limit")
    limit["required"] = True


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (removed, "list_jobs: GET /api/v1/jobs is gone."),
        (renamed, "list_jobs: GET /api/v1/jobs is called list_all_jobs now"),
        (moved, "list_jobs: it was at GET /api/v1/jobs and is at GET /api/v1/work."),
        (answers_less, "get_job: answer 200: field message is gone."),
        (answers_null, "get_job: answer 200: field message may be null now."),
        (answers_in_words, "get_job: answer 200: field fraction is string now, and was number."),
        (refusal_without_a_sentence, "every refusal: field detail is gone."),
        (forgets_the_total, "list_jobs: answer 200: header Total-Count is gone."),
        (takes_less, "plan_session: the body: field seed is refused now."),
        (takes_fewer, "plan_session: the body: field stops: maximum is 100 now, and was 200"),
        (takes_no_validation, "plan_session: the body: field role may not be 'validation' now."),
        (takes_for_granted, "plan_session: the body: field seed: left out it is 1 now, and was 0."),
        (wants_more, "plan_session: the body: field nest has to be given now."),
        (wants_something_new, "plan_session: the body: field gauge has to be given now."),
        (pages_of_a_hundred, "list_jobs: parameter query limit: maximum is 100 now, and was 1000."),
        (no_pages, "list_jobs: parameter query after is refused now."),
        (needs_a_limit, "list_jobs: parameter query limit has to be given now."),
    ],
)
def test_what_breaks_a_program_is_said(change, says):
    found = changed(change)

    assert any(sentence.startswith(says) for sentence in found), found


def new_operation(paths, schemas):
    paths["/api/v1/jobs/all"] = copy.deepcopy(paths["/api/v1/jobs"])
    paths["/api/v1/jobs/all"]["get"]["operationId"] = "list_all_jobs"


def answers_more(paths, schemas):
    schemas["JobReply"]["properties"]["worker"] = {"type": "string"}
    schemas["JobReply"]["required"].append("worker")


def answers_another_state(paths, schemas):
    schemas["JobState"]["enum"].append("postponed")


def takes_more(paths, schemas):
    schemas["ContactSessionRequest"]["properties"]["stops"]["maximum"] = 400
    schemas["ContactSessionRequest"]["properties"]["gauge"] = {"type": "string", "default": ""}


def takes_words_too(paths, schemas):
    stops = schemas["ContactSessionRequest"]["properties"]["stops"]
    schemas["ContactSessionRequest"]["properties"]["stops"] = {"anyOf": [stops, {"type": "string"}]}


def says_it_better(paths, schemas):
    schemas["JobReply"]["properties"]["message"]["description"] = "Said better."
    paths["/api/v1/jobs"]["get"]["summary"] = "Jobs"


def more_parameters(paths, schemas):
    state = {"name": "state", "in": "query", "required": False, "schema": {"type": "string"}}
    paths["/api/v1/jobs"]["get"]["parameters"].append(state)


@pytest.mark.parametrize(
    "change",
    [
        new_operation,
        answers_more,
        answers_another_state,
        takes_more,
        takes_words_too,
        says_it_better,
        more_parameters,
    ],
)
def test_what_is_added_breaks_nothing(change):
    assert changed(change) == []
