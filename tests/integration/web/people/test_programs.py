"""Tokens of programs: never more than their owner may at this moment, and what a plant says is marked."""

import pytest

from tests.helpers.web.clients import command
from tests.integration.web.bench import session_request
from truepose.domain.people import Role
from truepose.people.errors import AccountRefusedError
from truepose.web.middleware.rights import may

pytestmark = pytest.mark.asyncio(loop_scope="module")
PLAN = {"kind": "plan", "name": "monthly", "person": "Ada Byron", "document": {"name": "monthly"}}
PLANS = ("/api/v1/sessions",)


async def of_new(house, name, owner_role, role):
    """Return somebody new and the client of a program of theirs."""
    accounts = house.here.accounts
    owner = await accounts.register.enter(name, owner_role, "a test")
    _, secret = await accounts.make_token(owner, f"program of {name}", role, 1, "a test")
    return owner, house.client(secret)


async def codes(client, paths=PLANS):
    return [(await client.post(path, json={})).status_code for path in paths]


async def test_a_device_of_somebody_who_only_looks_now_plans_no_more(house):
    register = house.here.accounts.register
    owner, line = await of_new(house, "Mary Somerville", Role.OPERATOR, Role.DEVICE)
    async with line:
        before = await codes(line)
        await register.change_role(owner, Role.VIEWER, "a test")
        after = await line.post(PLANS[0], json={})
        looking = (await line.get("/api/v1/sessions")).status_code
        others = await codes(line)
        await register.change_role(owner, Role.OPERATOR, "a test")
        again = await codes(line)
        await register.remove(owner, "a test")
        gone = (await line.get("/api/v1/sessions")).status_code

    assert (before, others, again) == ([422], [403], [422])
    assert (after.status_code, looking, gone) == (403, 200, 401)
    assert after.json()["detail"] == (
        "program of Mary Somerville has the rights of Mary Somerville, whose role is now viewer; this "
        "requires the role operator or higher."
    )


async def test_a_device_has_no_session_move_and_may_halt_every_one(house):
    _, line = await of_new(house, "Caroline Herschel", Role.ADMINISTRATOR, Role.DEVICE)
    async with line:
        path = (await line.post("/api/v1/sessions", json=session_request())).headers["Location"]
        moving = [
            await command(line, path, name, person="Caroline Herschel")
            for name in ("start", "confirm", "resume")
        ]
        ended = await command(line, path, "abort", person=None)

    assert [answer.status_code for answer in moving] == [403, 403, 403]
    assert (ended.status_code, ended.json()["session"]["state"]) == (200, "aborted")


@pytest.mark.parametrize("owner_role", [Role.VIEWER, Role.OPERATOR, Role.METROLOGIST, Role.ADMINISTRATOR])
async def test_no_device_does_what_its_owner_may_not(house, owner_role):
    _, line = await of_new(house, f"owner as {owner_role}", owner_role, Role.DEVICE)
    async with line:
        corrected = (await line.post("/api/v1/models/1/corrections")).status_code
        accounts = (await line.post("/api/v1/people", json={})).status_code

    assert (corrected == 403) == (not may(owner_role, "correct_file"))
    assert accounts == 403


async def test_a_plant_s_token_is_an_administrator_s_and_ends_with_that_role(house):
    accounts = house.here.accounts
    with pytest.raises(AccountRefusedError, match="a token of this person cannot have more rights"):
        await of_new(house, "Sophie Germain", Role.METROLOGIST, Role.PLANT)
    owner, plant = await of_new(house, "Maria Agnesi", Role.ADMINISTRATOR, Role.PLANT)
    async with plant:
        before = (await plant.get("/api/v1/chain/links")).status_code
        await accounts.register.change_role(owner, Role.METROLOGIST, "a test")
        after = (await plant.get("/api/v1/chain/links")).status_code

    assert (before, after) == (200, 403)


async def test_whom_a_plant_names_is_marked_as_said_by_it(house):
    async with house.of(Role.PLANT) as plant, house.of(Role.ADMINISTRATOR) as ada:
        handed = await plant.post("/api/v1/hand-downs", json=PLAN, headers={"Idempotency-Key": "said-1"})
        page = (await ada.get("/hand-downs")).text
        await house.here.log.written()
        (act,) = (await ada.get("/api/v1/audit", params={"search": "according to the plant"})).json()["acts"]

    assert (handed.json()["person"], handed.json()["said_by"]) == ("Ada Byron", "plant")
    assert "Sent by Ada Byron, according to the plant plant," in page
    assert (act["person"], act["reason"]) == ("plant", "pushed by Ada Byron, according to the plant")
