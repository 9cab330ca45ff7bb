"""The OpenAPI document is true: whatever a client generates from it, the service answers as documented."""

import asyncio
import contextlib
import re
from http.cookiejar import DefaultCookiePolicy

import jsonschema_rs
import pytest
import requests
import schemathesis
from hypothesis import HealthCheck, given, settings
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode
from schemathesis.specs.openapi.checks import positive_data_acceptance

from tests.helpers.web import routes
from tests.helpers.web.routes import operations_of, routes_alone
from tests.integration.web.bench import CELL, Bench
from tests.integration.web.listening import listening
from truepose.analysis.job_queue.accuracy_tasks import PromiseTask
from truepose.app import create_app
from truepose.settings import Settings

# Streams do not end by themselves; `test_events.py` and `test_ballbar_live.py` are about them.
STREAMS = [
    "/api/v1/events",
    "/api/v1/sessions/{id}/live",
]
OPERATIONS = [(method, path) for method, path in operations_of(routes_alone()) if path not in STREAMS]
UPLOADS = {("post", "/api/v1/campaigns"), ("post", "/api/v1/models/{id}/corrections")}
FEW = 2  # of each kind, each operation: the simplest and a drawn one; `make thorough` draws more


async def never_done(task, told):
    if isinstance(task, PromiseTask):  # is waited for
        return await asyncio.to_thread(task.perform, lambda fraction, doing: None)
    return await asyncio.sleep(3600)


@pytest.fixture(scope="module")
def document():
    return routes.document()


@pytest.fixture(scope="module")
def api(tmp_path_factory):
    folder = tmp_path_factory.mktemp("service")
    (folder / "cell.toml").write_text(CELL)
    where = Settings(database_url=f"sqlite:///{folder}/truepose.sqlite3", cell_file=folder / "cell.toml")
    with listening(create_app(where, Bench().registry(), never_done)) as url:
        yield schemathesis.openapi.from_url(f"{url}/openapi.json", timeout=60)  # a second on an idle machine


@pytest.fixture(scope="module")
def connection():
    """One for all requests: to connect anew takes as long as most answers."""
    with requests.Session() as session:
        session.trust_env = False
        session.cookies.set_policy(DefaultCookiePolicy(allowed_domains=[]))
        yield session


def assert_answered_as_documented(operation, mode, connection, examples=FEW):
    # That bytes are a campaign or a program is more than a schema can say.
    upload = (operation.method, operation.path) in UPLOADS

    @settings(max_examples=examples, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(case=operation.as_strategy(generation_mode=mode))
    def answers(case):
        unchecked = [positive_data_acceptance] if upload else []
        case.call_and_validate(excluded_checks=unchecked, timeout=60, session=connection)

    answers()


@pytest.mark.parametrize(("method", "path"), OPERATIONS)
def test_what_fits_the_schema_is_answered_as_documented(api, connection, method, path):
    assert_answered_as_documented(api[path][method], GenerationMode.POSITIVE, connection)


@pytest.mark.parametrize(("method", "path"), OPERATIONS)
def test_what_does_not_fit_the_schema_is_refused_as_documented(api, connection, method, path):
    with contextlib.suppress(Unsatisfiable):  # nothing can be wrong about a request without parameters
        assert_answered_as_documented(api[path][method], GenerationMode.NEGATIVE, connection)


def fields(schema, found):
    if isinstance(schema, dict):
        found.update(schema.get("properties", {}))
        for part in schema.values():
            fields(part, found)
    if isinstance(schema, list):
        for part in schema:
            fields(part, found)
    return found


def test_the_document_has_every_operation(document):
    listed = {(method, path) for path, methods in document["paths"].items() for method in methods}

    assert listed == {*OPERATIONS, *(("get", stream) for stream in STREAMS)}


def test_every_number_that_is_a_quantity_names_its_unit(document):
    counts = re.compile(
        r"^(id|\w+_id|\w+_ids|n|config|next_config|nest|face|sign|joint|joints|direction|samples|port|status|seed|attachment"
        r"|supersedes|superseded_by|repeat_of|done|skipped|planned|measured|configurations?|observations"
        r"|parameters|outliers|\w+_points|\w+_legs|\w+_contacts|\w+_readings|reference_every|fraction"
        r"|number|\w+_number|entry|index|count|\w+_count|attempt|placement|poses|\w+_poses|base_point|base|tool"
        r"|corrected|total|far_moved|outside|line|a|b|legs|readings|watching|initialisation|exchanged"
        r"|axes|row|group|revisits|degrees_of_freedom|targets?|advised|nests|cycles|visits|set_aside|struck|rows|leads_to|first_line|column|left_out|revision|point|first|second|newest|links)$"
    )
    # A ratio has no unit; the unit of a parameter, an amplitude or a curve stands beside its value.
    ratios = {"scale", "scale_standard_uncertainty", "chi2_per_dof", "p_value", "share", "lack_of_fit_ratio"}
    ratios |= {
        "tail_degrees_of_freedom",
        "order",
        "gain",
        "gain_interval_95",
        "foretold_share",
        "positive_share",
        "discrepancy_known_to",
        "times_before",
        "times_after",
        "amount",
        "widths",
    }
    ratios |= {
        "value",
        "standard_uncertainty",
        "prior_width",
        "amplitude",
        "amplitude_standard_uncertainty",
        "difference",
        "noise",
    }
    ratios |= {"values"}  # of a series: each column names its own
    ratios |= {"x", "residual", "line_x", "line", "line_band", "quaternion", "noise_chance", "axis", "normal"}
    units = re.compile(r"_(mm|bytes|deg|s|c|kg|mm_s|deg_s|s_per_reading)$|^(minutes|hours)$")

    numeric = {
        name
        for name, field in fields(document["components"]["schemas"], {}).items()
        if {"number", "integer"} & types_of(field)
    }

    assert {n for n in numeric - ratios if not counts.match(n) and not units.search(n)} == set()


def types_of(field):
    """Return the JSON types a field may have, through arrays and alternatives."""
    found = {field.get("type")}
    for part in [*field.get("anyOf", []), *([field["items"]] if "items" in field else [])]:
        found |= types_of(part)
    return found


@pytest.mark.parametrize(("method", "path"), [*OPERATIONS, *(("get", stream) for stream in STREAMS)])
def test_every_operation_lists_its_problems_and_says_what_it_does(document, method, path):
    operation = document["paths"][path][method]

    assert operation["description"]
    for status, reply in operation["responses"].items():
        assert reply["description"]
        if int(status) >= 400:
            assert list(reply["content"]) == ["application/problem+json"]
    if "requestBody" in operation:
        assert {"413", "415", "422"} <= operation["responses"].keys()


def test_the_summary_of_an_operation_says_what_it_does(document):
    shown = document["paths"]["/api/v1/drafts"]["get"]

    assert shown["summary"] == "List drafts, latest first; there are 20 at most"
    assert shown["description"] == f"{shown['summary']}."


BEGINS_WITH_A_VERB = re.compile(
    r"("
    r"accept|add|cancel|change|choose|claim|close|command|compare|confirm|connect|correct|diagnose|"
    r"disconnect|download|end|enter|"
    r"find|follow|get|give|identify|list|make|plan|read|start|upload|"
    r"remove|revoke|show|sign|switch|use|validate"
    r")(_[a-z]+)+"
)


def test_every_operation_has_a_name_of_its_own_that_begins_with_what_it_does(document):
    every = [operation for methods in document["paths"].values() for operation in methods.values()]
    names = [operation["operationId"] for operation in every]

    assert sorted(set(names)) == sorted(names)
    assert [name for name in names if not BEGINS_WITH_A_VERB.fullmatch(name)] == []


def test_every_list_says_how_long_it_is(document):
    listed = {
        operation["operationId"]: "Total-Count" in answer.get("headers", {})
        for methods in document["paths"].values()
        for operation in methods.values()
        for answer in [operation["responses"].get("200", {})]
        if answer.get("content", {}).get("application/json", {}).get("schema", {}).get("type") == "array"
    }

    assert len(listed) > 15
    assert [name for name, says in listed.items() if not says] == []


def contents_in_json(document):
    for methods in document["paths"].values():
        for operation in methods.values():
            for holder in (operation.get("requestBody", {}), *operation["responses"].values()):
                if "application/json" in holder.get("content", {}):
                    yield operation["operationId"], holder["content"]["application/json"]


def test_every_body_and_every_reply_in_json_has_an_example_that_fits(document):
    shown = list(contents_in_json(document))

    assert [name for name, content in shown if "example" not in content] == []
    assert [
        name for name, content in shown if not fits(document, content["schema"], content["example"])
    ] == []


def fits(document, schema, example):
    return jsonschema_rs.is_valid({**schema, "components": document["components"]}, example)


def test_an_example_that_does_not_fit_is_found(document):
    problem = {"$ref": "#/components/schemas/Problem"}

    assert not fits(document, problem, {"status": "404"})


def test_no_parameter_is_said_to_be_null(document):
    parameters = [
        parameter
        for methods in document["paths"].values()
        for operation in methods.values()
        for parameter in operation.get("parameters", [])
    ]

    assert [one["name"] for one in parameters if "null" in types_of(one["schema"])] == []


def test_texts_in_addresses_are_documented_without_the_zero_byte_that_none_may_hold(document):
    texts = [
        parameter["schema"]
        for operations in document["paths"].values()
        for operation in operations.values()
        for parameter in operation.get("parameters", [])
        if parameter["in"] != "header" and parameter["schema"].get("type") == "string"
    ]
    patterns = [schema["pattern"] for schema in texts if not schema.keys() & {"enum", "format"}]

    assert [pattern for pattern in patterns if re.search(pattern, "a\0b")] == []
    assert sum(re.search(pattern, "left arm") is not None for pattern in patterns) >= 10
