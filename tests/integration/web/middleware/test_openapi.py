"""The OpenAPI document is true: it has every operation, unit, error and example.

That requests drawn from it are answered as documented is a matter of `make thorough`.
"""

import re

import jsonschema_rs
import pytest

from tests.helpers.web import routes
from tests.helpers.web.routes import operations_of, routes_alone

# Streams do not end by themselves; `test_events.py` and `test_ballbar_live.py` are about them.
STREAMS = [
    "/api/v1/events",
    "/api/v1/sessions/{id}/live",
]
OPERATIONS = [(method, path) for method, path in operations_of(routes_alone()) if path not in STREAMS]


@pytest.fixture(scope="module")
def document():
    return routes.document()


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
        "at_low",  # with `unit`
        "at_high",
        "order",
        "gain",
        "gain_interval_95",
        "foretold_share",
        "named_share",
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
