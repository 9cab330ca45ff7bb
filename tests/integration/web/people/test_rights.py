"""Every role at every operation and every page: who may is let through, everybody else is not."""

import contextlib
import itertools
import re

import pytest
import pytest_asyncio

from tests.helpers.web.routes import asked, routes_alone
from truepose.domain.people import Role
from truepose.web.middleware.authorization import AuthorizationMiddleware
from truepose.web.middleware.rights import LEAST, Anybody, MissingRightError, may, require_complete
from truepose.web.middleware.routing import operations_of
from truepose.web.plant.application import create_plant_application

in_one_loop = pytest.mark.asyncio(loop_scope="module")
OPERATIONS = operations_of(routes_alone().routes)
OF_PLANT = operations_of(create_plant_application("test", contextlib.nullcontext).routes)
HOST = ("host", "localhost")
ROLES = [None, *Role]
# What is let through is not done: what the gate passes on ends here.
PASSED = 299


@pytest_asyncio.fixture(loop_scope="module")
async def passing(house, monkeypatch):
    """The service with nothing behind its gate."""
    await asked(house.app, "GET", "/health", [HOST])  # the layers are put together for the first request
    gate = house.app.middleware_stack
    while not isinstance(gate, AuthorizationMiddleware):
        gate = getattr(gate, "app", None) or gate._app

    async def behind(scope, receive, send):
        await send({"type": "http.response.start", "status": PASSED, "headers": []})
        await send({"type": "http.response.body", "body": b""})

    monkeypatch.setattr(gate, "_app", behind)
    return house


def address(operation):
    return re.sub(r"{[^}]+}", "1", operation.path)


def shown(house, role):
    return [] if role is None else [("authorization", f"Bearer {house.tokens[role]}")]


@in_one_loop
@pytest.mark.parametrize("role", ROLES)
async def test_a_role_gets_what_the_table_says_and_nothing_else(passing, role):
    let_in, kept_out = set(), set()
    for operation in OPERATIONS:
        for method in sorted(operation.methods - {"HEAD"}):
            headers = [HOST, ("origin", "http://localhost"), *shown(passing, role)]
            answer = await asked(passing.app, method, address(operation), headers)
            (let_in if answer.status == PASSED else kept_out).add(operation.name)
            assert answer.status in {PASSED, 401, 403} or (
                answer.headers["location"].startswith(("/sign-in?", "/not-yours?"))
            ), (method, operation.path)

    anybody = {name for name, least in LEAST.items() if isinstance(least, Anybody)}
    expected = anybody if role is None else {o.name for o in OPERATIONS if may(role, o.name)}
    assert let_in == expected & {operation.name for operation in OPERATIONS}
    assert kept_out == {operation.name for operation in OPERATIONS} - let_in


@pytest.mark.parametrize(
    ("role", "operation"),
    [
        (Role.VIEWER, "plan_session"),
        (Role.VIEWER, "identify_campaign"),
        (Role.OPERATOR, "correct_file"),
        (Role.OPERATOR, "list_acts"),
        (Role.METROLOGIST, "enter_person"),
        (Role.METROLOGIST, "make_token"),
        (Role.DEVICE, "close_session"),
        (Role.DEVICE, "list_people"),
        (Role.DEVICE, "make_watch_link"),
    ],
)
def test_the_table_keeps_out(role, operation):
    assert not may(role, operation)


@pytest.mark.parametrize("role", [role for role in Role if role is not Role.PLANT])
def test_whoever_is_known_may_stop_the_robot(role):
    assert may(role, "command_session")


def test_a_plant_collects_and_hands_down_and_nothing_else():
    assert {name for name in LEAST if may(Role.PLANT, name) and not isinstance(LEAST[name], Anybody)} == {
        "get_chain_head",
        "list_links",
        "accept_hand_down",
        "list_hand_downs",
        "get_hand_down",
    }


@pytest.mark.parametrize("role", [Role.VIEWER, Role.OPERATOR, Role.METROLOGIST, Role.DEVICE])
def test_the_chain_is_for_plants(role):
    assert not may(role, "list_links")


def test_each_rung_has_what_the_one_below_has():
    ladder = [Role.VIEWER, Role.OPERATOR, Role.METROLOGIST, Role.ADMINISTRATOR]
    rights = [{name for name in LEAST if may(role, name)} for role in ladder]

    assert all(low < high for low, high in itertools.pairwise(rights))
    assert rights[-1] == LEAST.keys()


def test_an_operation_that_nobody_has_judged_keeps_the_service_from_starting():
    with pytest.raises(MissingRightError, match="launch_rocket"):
        require_complete([*LEAST, "launch_rocket"])


def test_the_table_names_nothing_that_is_not_there():
    assert LEAST.keys() - {operation.name for operation in (*OPERATIONS, *OF_PLANT)} == set()


@in_one_loop
async def test_what_is_not_there_is_told_to_nobody_unknown(house):
    headers = [HOST]

    assert (await asked(house.app, "GET", "/api/v1/nothing", headers)).status == 401
    assert (
        await asked(house.app, "PUT", "/api/v1/sessions", [*headers, ("origin", "http://localhost")])
    ).status == 401
    known = [*headers, *shown(house, Role.VIEWER)]
    assert (await asked(house.app, "GET", "/api/v1/nothing", known)).status == 404
    assert (
        await asked(house.app, "TRACE", "/api/v1/sessions", [*known, ("origin", "http://localhost")])
    ).status == 405


@in_one_loop
async def test_a_page_leads_whoever_is_unknown_to_signing_in(house):
    answer = await asked(house.app, "GET", "/sessions/7", [HOST])

    assert (answer.status, answer.headers["location"]) == (
        303,
        "/sign-in?next=/sessions/7%3Fstop_after_s%3D0.01",
    )


@in_one_loop
async def test_what_is_refused_is_on_record_without_control_characters(house, monkeypatch):
    acts = []
    monkeypatch.setattr(house.here.log, "note", acts.append)
    async with house.of(Role.OPERATOR) as operator:
        nowhere = await operator.post("/api/v1/devices/%00/connect")
        body = {"command": "nothing", "reason": "\0" + 9000 * "x"}
        unread = await operator.post("/api/v1/sessions/1/commands", json=body)

    texts = [text for act in acts for text in (act.resource, act.reason) if text]
    assert [act.status for act in acts] == [nowhere.status_code, unread.status_code] == [422, 422]
    assert not [text for text in texts if "\0" in text or len(text) > 2000]


@in_one_loop
async def test_a_body_that_is_nested_too_deep_is_refused_before_anybody_is_known(house):
    async with house.client() as nobody:
        deep = 600 * "[" + 600 * "]"
        reply = await nobody.post(
            "/api/v1/sign-ins", content=f'{{"name": {deep}}}', headers={"Content-Type": "application/json"}
        )

    assert reply.status_code == 422
