"""What a plant hands down: kept once, shown, used by a person, and nothing moves by itself."""

import json

import pytest

PLAN = {"kind": "plan", "name": "monthly check", "person": "Ada Byron", "document": {"name": "monthly"}}
KEY = {"Idempotency-Key": "hand-down-1"}
JSON = {"Content-Type": "application/json"}


@pytest.fixture
async def taken(client):
    answer = await client.post("/api/v1/hand-downs", json=PLAN, headers=KEY)
    assert answer.status_code == 201, answer.text
    return answer


async def test_what_is_handed_down_is_shown_and_nothing_is_planned(client, taken):
    listed = (await client.get("/api/v1/hand-downs")).json()

    assert [(one["kind"], one["name"], one["document"]) for one in listed] == [
        ("plan", "monthly check", {"name": "monthly"})
    ]
    assert taken.headers["Location"] == "/api/v1/hand-downs/1"
    assert (await client.get("/api/v1/sessions")).json() == []


async def test_sent_again_it_is_kept_once(client, taken):
    again = await client.post("/api/v1/hand-downs", json=PLAN, headers=KEY)

    assert (again.status_code, again.json()) == (201, taken.json())
    assert len((await client.get("/api/v1/hand-downs")).json()) == 1


async def test_another_one_under_the_same_key_is_refused(client, taken):
    other = await client.post("/api/v1/hand-downs", json=PLAN | {"name": "other"}, headers=KEY)

    assert other.status_code == 409


async def test_whoever_uses_it_is_on_record_in_the_chain(client, taken):
    used = await client.post("/api/v1/hand-downs/1/uses", json={"person": "Alan", "note": "session 12"})

    assert [(use["person"], use["note"]) for use in used.json()["uses"]] == [("Alan", "session 12")]
    links = (await client.get("/api/v1/chain/links")).text
    assert '"record":"handed_down"' in links
    assert '"record":"hand_down_uses"' in links


async def test_what_was_never_handed_down_cannot_be_used(client):
    answer = await client.post("/api/v1/hand-downs/7/uses", json={"person": "Alan"})

    assert (answer.status_code, answer.json()["detail"]) == (404, "There is no hand-down 7.")


@pytest.mark.parametrize("wrong", [{"kind": "robot"}, {"name": ""}, {"person": ""}, {"document": []}])
async def test_what_is_no_hand_down_is_refused(client, wrong):
    answer = await client.post("/api/v1/hand-downs", json=PLAN | wrong, headers=KEY)

    assert answer.status_code == 422


@pytest.mark.parametrize(
    ("said", "because"),
    [
        ("NaN", "document: a number that is not finite"),
        ('[{"b": -Infinity}]', "document: a number that is not finite"),
        ("1e999", "document: a number that is not finite"),
        ('"\\ud800"', "document: half a character"),
    ],
)
async def test_what_no_other_program_takes_for_json_is_refused(client, said, because):
    body = json.dumps(PLAN).replace('"monthly"', said)

    answer = await client.post("/api/v1/hand-downs", content=body, headers=KEY | JSON)

    assert (answer.status_code, answer.json()["detail"][: len(because)]) == (422, because)
    assert (await client.get("/api/v1/hand-downs")).json() == []
