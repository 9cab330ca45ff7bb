"""What a plant hands down: kept once, shown, used by a person, and nothing moves by itself."""

import json
import math

import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, parameters_of
from tests.helpers.web.clients import made
from truepose.domain.identification import NestCentre, Parameter
from truepose.exchange.models.digest import digest_of
from truepose.exchange.models.file import model_text
from truepose.web.pages import cell

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

    assert (answer.status_code, answer.json()["detail"]) == (404, "There is no deployment 7.")


@pytest.mark.parametrize("wrong", [{"kind": "robot"}, {"name": ""}, {"person": ""}, {"document": []}])
async def test_what_is_no_hand_down_is_refused(client, wrong):
    answer = await client.post("/api/v1/hand-downs", json=PLAN | wrong, headers=KEY)

    assert answer.status_code == 422


@pytest.mark.parametrize(
    ("said", "because"),
    [
        ("NaN", "document: numbers must be finite"),
        ('[{"b": -Infinity}]', "document: numbers must be finite"),
        ("1e999", "document: numbers must be finite"),
        ('"\\ud800"', "The body contains an unpaired surrogate"),
    ],
)
async def test_what_no_other_program_takes_for_json_is_refused(client, said, because):
    body = json.dumps(PLAN).replace('"monthly"', said)

    answer = await client.post("/api/v1/hand-downs", content=body, headers=KEY | JSON)

    assert (answer.status_code, answer.json()["detail"][: len(because)]) == (422, because)
    assert (await client.get("/api/v1/hand-downs")).json() == []


def handed_model(app, *parameters, **changes):
    """Return a model as a plant hands it down, made with the tool of the cell."""
    cell = app.state.context.cell
    nests = tuple(NestCentre(n, nest.centre_mm) for n, nest in enumerate(cell.nests, 1))
    stands = parameters_of("base", [("base_x", 0.4, "mm"), ("base_rz", 1e-3, "rad")])
    model = model_of(IRB_120, *(parameters or stands), base=cell.base_nominal, nests=nests)
    document = json.loads(model_text(model)) | changes
    signed = document | {"digest": digest_of(document)}
    return PLAN | {"kind": "model", "name": "of the type", "document": signed}


@pytest.fixture
async def handed(client, app):
    """A model of the cell's own robot and tool was handed down."""
    await client.post("/api/v1/hand-downs", json=handed_model(app), headers=KEY)


async def accept(client, number=1, **said):
    body = {"person": "Grace Hopper", **said}
    return await client.post(f"/api/v1/hand-downs/{number}/acceptance", json=body)


async def test_a_model_is_one_of_the_cell_only_once_somebody_accepts_it(client, handed):
    before = (await client.get("/api/v1/models")).json()

    accepted = await accept(client)
    again = await accept(client)

    assert (before, accepted.status_code, again.status_code) == ([], 201, 409), accepted.text
    (model,) = (await client.get("/api/v1/models")).json()
    assert accepted.json() == model
    assert (model["identification_id"], model["diagnosis_id"]) == (None, None)
    assert (model["handed_down_id"], model["accepted_by"]) == (1, "Grace Hopper")
    (shown,) = (await client.get("/api/v1/hand-downs")).json()
    assert shown["model_id"] == model["id"]
    assert [use["person"] for use in shown["uses"]] == ["Grace Hopper"]


async def test_an_accepted_model_corrects_and_is_listed_with_its_origin(client, handed):
    await accept(client)
    target = b"target,x_mm,y_mm,z_mm,qw,qx,qy,qz,note\nnear,350,100,400,0,0,1,0,ok\n"

    sent = await client.post("/api/v1/models/1/corrections", files=[("file", ("t.csv", target))])
    corrected = (await client.get(await made(client, sent))).json()
    paths = ("/models/1", "/work", "/hand-downs")
    page, work, handed_down = [(await client.get(path)).text for path in paths]

    assert corrected["model_id"] == 1
    assert (await client.get("/api/v1/models/1/corrections")).json()[0]["id"] == corrected["id"]
    assert "accepted by Grace Hopper" in page
    assert "Model 1: of the type" in work
    assert 'href="/models/1"' in handed_down


async def test_a_model_of_another_robot_or_no_model_is_refused_with_a_sentence(client, app):
    document = handed_model(app)["document"]
    other = document["robot"] | {"name": "KUKA KR 6"}
    for number, changes in enumerate(({"robot": other}, {"format": "something"}), 1):
        await client.post(
            "/api/v1/hand-downs", json=handed_model(app, **changes), headers={"Idempotency-Key": f"k{number}"}
        )
    await client.post("/api/v1/hand-downs", json=PLAN, headers=KEY)

    answers = [await accept(client, number) for number in (1, 2, 3, 4)]

    assert [answer.status_code for answer in answers] == [409, 409, 409, 404]
    assert "KUKA KR 6; this cell has ABB IRB 120" in answers[0].json()["detail"]
    assert "The pushed model cannot be read" in answers[1].json()["detail"]
    assert "is a plan, not a model" in answers[2].json()["detail"]
    assert (await client.get("/api/v1/models")).json() == []


BASE_FAR = Parameter("base_x", "base", 5000.0, "mm", 0.01, 10.0)
JOINT_FAR = Parameter("theta_2", "geometry", math.radians(40.0), "rad", 1e-5, 0.005)


@pytest.mark.parametrize(("far", "least_mm"), [(BASE_FAR, 5000.0), (JOINT_FAR, 200.0)], ids=["base", "joint"])
async def test_a_model_that_moves_the_tool_far_is_accepted_only_with_its_shift_confirmed(
    client, app, far, least_mm
):
    await client.post("/api/v1/hand-downs", json=handed_model(app, far), headers=KEY)

    check = (await client.get("/api/v1/hand-downs/1/check")).json()
    page = (await client.get("/hand-downs")).text
    shift_mm = check["largest_shift_mm"]
    believed = await accept(client)
    too_little = await accept(client, accepted_shift_mm=100.0)
    confirmed = await accept(client, accepted_shift_mm=shift_mm)

    assert check["confirmation_needed"] and check["digest"] == "intact"
    assert shift_mm > least_mm
    assert [one["name"] for one in check["far_from_prior"]] == [far.name]
    assert 'type="checkbox" name="accepted_shift_mm"' in page
    assert (believed.status_code, too_little.status_code, confirmed.status_code) == (409, 409, 201)
    assert f"moves the tool by up to {shift_mm:.4g} mm" in believed.json()["detail"]
    assert far.name in believed.json()["detail"]


async def test_every_model_that_the_page_shows_is_checked_however_many_came_later(client, app, monkeypatch):
    monkeypatch.setattr(cell, "_HANDED_DOWN", 2)
    await client.post("/api/v1/hand-downs", json=handed_model(app, BASE_FAR), headers=KEY)
    for number in range(2):
        later = handed_model(app) | {"name": f"later {number}"}
        await client.post("/api/v1/hand-downs", json=later, headers={"Idempotency-Key": f"later-{number}"})

    newest = (await client.get("/hand-downs")).text
    older = (await client.get("/hand-downs?before=2")).text

    assert [text.count("shifts the tool by up to") for text in (newest, older)] == [2, 1]
    assert 'href="/hand-downs?before=2"' in newest
    assert 'type="checkbox" name="accepted_shift_mm"' in older
    assert 'href="/hand-downs?before=' not in older


async def test_a_model_near_the_nominal_robot_needs_no_confirmation(client, handed):
    check = (await client.get("/api/v1/hand-downs/1/check")).json()
    page = (await client.get("/hand-downs")).text

    assert not check["confirmation_needed"]
    assert check["largest_shift_mm"] < check["limit_mm"] == 5.0
    assert "accepted_shift_mm" not in page


async def test_a_model_that_was_edited_on_the_way_is_refused(client, app):
    edited = handed_model(app)
    edited["document"]["parameters"][0]["value"] += 1.0
    await client.post("/api/v1/hand-downs", json=edited, headers=KEY)

    answer = await accept(client)

    assert answer.status_code == 409
    assert "was edited after truepose wrote it" in answer.json()["detail"]
