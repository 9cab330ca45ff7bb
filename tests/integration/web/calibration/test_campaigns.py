"""Campaigns over REST: uploaded, made of sessions, downloaded."""

import asyncio
import contextlib
import io
import zipfile
from datetime import date

import numpy as np
import pytest

from tests.helpers.domain.builders import make_campaign
from tests.helpers.machine import HANGS_S
from tests.integration.web.bench import ZIP, measured, number_of, planned
from tests.integration.web.leaving_clients import LeavingClient, Waiting
from truepose.analysis.job_queue.tasks import stored_campaign
from truepose.analysis.job_queue.uploads import Uploads
from truepose.exchange.campaigns.zip_file import read_campaign_zip, write_campaign_zip

CAMPAIGNS = "/api/v1/campaigns"
ARCHIVE = write_campaign_zip(make_campaign())
FORM = {"file": ("left arm.zip", ARCHIVE, "application/zip")}


@pytest.fixture
def uploads():
    return Uploads()


def zipped(**files):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, text in files.items():
            archive.writestr(name.replace("__", "."), text)
    return stream.getvalue()


async def test_an_upload_comes_back_byte_for_byte(client):
    stored = await client.post(CAMPAIGNS, content=ARCHIVE, headers=ZIP, params={"name": "mine"})
    back = await client.get(stored.json()["archive_url"])

    assert stored.status_code == 201
    assert stored.json()["name"] == "mine"
    assert stored.json()["calibration_points"] == len(make_campaign().calibration)
    assert back.content == ARCHIVE
    assert back.headers["content-type"] == "application/zip"


async def test_a_form_with_a_file_serves_as_well(client):
    stored = await client.post(CAMPAIGNS, files=FORM)

    assert stored.status_code == 201, stored.text
    assert stored.json()["name"] == "left arm"


async def test_the_day_of_the_readings_is_asked_for_and_not_made_up(client):
    dated = write_campaign_zip(make_campaign(measured_on=date(2025, 11, 3)))

    told = [
        await client.post(CAMPAIGNS, content=ARCHIVE, headers=ZIP),
        await client.post(CAMPAIGNS, content=ARCHIVE, headers=ZIP, params={"measured_on": "2026-03-03"}),
        await client.post(CAMPAIGNS, files=FORM, data={"measured_on": "2026-03-03"}),
        await client.post(CAMPAIGNS, files=FORM, data={"measured_on": ""}),
        await client.post(CAMPAIGNS, content=dated, headers=ZIP),
        await client.post(CAMPAIGNS, content=dated, headers=ZIP, params={"measured_on": "2026-03-03"}),
    ]

    days = [reply.json()["measured_on"] for reply in told]
    assert days == [None, "2026-03-03", "2026-03-03", None, "2025-11-03", "2026-03-03"]


async def test_whose_readings_they_are_is_as_somebody_says(client):
    told = write_campaign_zip(make_campaign(robot_serial_number="120-1", instrument_serial_number="T-7"))
    said = {"robot_serial_number": "120-2"}

    answers = [
        await client.post(CAMPAIGNS, content=ARCHIVE, headers=ZIP),
        await client.post(CAMPAIGNS, content=told, headers=ZIP),
        await client.post(CAMPAIGNS, content=told, headers=ZIP, params=said),
        await client.post(CAMPAIGNS, files={"file": ("a.zip", told, "application/zip")}, data=said),
    ]
    refused = await client.post(CAMPAIGNS, content=told, headers=ZIP, params={"robot_serial_number": " "})
    silent, of_robot = [(await client.get(f"/campaigns/{number}")).text for number in (1, 3)]

    found = [[reply.json()[f"{of}_serial_number"] for of in ("robot", "instrument")] for reply in answers]
    assert found == [[None, None], ["120-1", "T-7"], ["120-2", "T-7"], ["120-2", "T-7"]]
    assert (refused.status_code, "robot_serial_number" in refused.json()["detail"]) == (422, True)
    assert "robot_serial_number in campaign.json" in silent
    assert "120-2" in of_robot


@pytest.mark.parametrize("said", ["3 March", "1700006400", "1700006400000", "2026-02-30"])
async def test_a_day_that_is_none_is_refused_and_nothing_is_stored(client, said):
    refused = [
        await client.post(CAMPAIGNS, content=ARCHIVE, headers=ZIP, params={"measured_on": said}),
        await client.post(CAMPAIGNS, files=FORM, data={"measured_on": said}),
    ]

    assert [reply.status_code for reply in refused] == [422, 422]
    assert all("measured_on" in reply.json()["detail"] for reply in refused)
    assert (await client.get(CAMPAIGNS)).json() == []


async def test_an_upload_sent_twice_with_one_key_is_stored_once(client):
    sent = {"content": ARCHIVE, "headers": {**ZIP, "Idempotency-Key": "u-1"}}

    first, again = [await client.post(CAMPAIGNS, **sent) for _ in range(2)]

    assert first.json() == again.json()
    assert len((await client.get(CAMPAIGNS)).json()) == 1


@pytest.mark.parametrize(
    ("archive", "sentence"),
    [
        (b"PK no zip at all", "not a complete zip file"),
        (ARCHIVE[:-30], "not a complete zip file"),
        (zipped(readme__txt="hello"), "no campaign.json in the archive"),
        (zipped(campaign__json="{"), "campaign.json"),
        (b"", "the zip of a campaign folder is required"),
    ],
)
async def test_a_bad_zip_is_refused_with_a_sentence_and_nothing_is_stored(client, archive, sentence):
    refused = await client.post(CAMPAIGNS, content=archive, headers=ZIP)

    assert refused.status_code == 422
    assert sentence in refused.json()["detail"]
    assert (await client.get(CAMPAIGNS)).json() == []


async def test_a_form_without_a_file_is_refused(client):
    refused = await client.post(CAMPAIGNS, files={"other": ("x.zip", b"x")})

    assert refused.status_code == 422
    assert "the zip of a campaign folder is required" in refused.json()["detail"]


async def test_a_session_becomes_a_campaign_that_can_be_read(client, until):
    path = await measured(client, until)
    validation = number_of(await measured(client, until, role="validation"))

    made = await client.post(
        f"{path}/campaign", json={"name": "left arm", "validation_session_id": validation}
    )
    archive = (await client.get(made.json()["archive_url"])).content
    campaign = read_campaign_zip(archive)

    assert made.status_code == 201, made.text
    assert made.json()["session_ids"] == [number_of(path), validation]
    assert (len(campaign.calibration), len(campaign.validation)) == (3, 3)
    assert campaign.registration is not None
    assert len(campaign.reference) >= 6  # three nests, before and after


async def test_a_worker_is_handed_the_digits_of_the_readings_and_a_folder_rounds_them(client, until, app):
    path = await measured(client, until)
    made = await client.post(f"{path}/campaign", json={"name": "left arm"})
    readings = (await client.get("/api/v1/readings", params={"kind": "point"})).json()

    handed = stored_campaign(await app.state.context.campaigns.content(made.json()["id"])).calibration
    first, again = [(await client.get(made.json()["archive_url"])).content for _ in range(2)]
    folder = read_campaign_zip(first).calibration

    assert again == first
    assert handed.position_mm.tolist() == [reading["position_world_mm"] for reading in readings]
    np.testing.assert_allclose(folder.position_mm, handed.position_mm, rtol=0, atol=0.5001e-5)
    assert folder.stops.config.tolist() == handed.stops.config.tolist()


async def test_readings_kept_for_validation_never_identify(client, until):
    path = await measured(client, until, role="validation")

    refused = await client.post(f"{path}/campaign", json={"name": "left arm"})

    assert refused.status_code == 409
    detail = refused.json()["detail"]
    assert "The readings of session 1 are for validation and must not be used to identify" in detail
    assert (await client.get(CAMPAIGNS)).json() == []


async def test_a_session_does_not_judge_the_model_that_it_identifies(client, until):
    path = await measured(client, until)
    wanted = {"name": "left arm", "validation_session_id": number_of(path)}

    refused = await client.post(f"{path}/campaign", json=wanted)

    assert refused.status_code == 409
    assert "cannot validate the model that it identifies" in refused.json()["detail"]


async def test_a_session_that_never_ran_makes_no_campaign(client):
    refused = await client.post(f"{await planned(client)}/campaign", json={"name": "left arm"})

    assert refused.status_code == 409
    assert refused.json()["detail"] == "Session 1 has no readings of a tool nest; run the session first."


async def test_sessions_named_in_json_make_a_campaign(client, until):
    number = number_of(await measured(client, until))

    stored = await client.post(CAMPAIGNS, json={"name": "mine", "session_ids": [number]})

    assert stored.status_code == 201, stored.text
    assert stored.json()["session_ids"] == [number]
    assert stored.json()["calibration_points"] == 3


@pytest.mark.parametrize(
    ("body", "what"),
    [
        ('{"session_ids": []}', "session_ids"),
        ('{"session_ids": [1], "rest": 2}', "rest"),
        ("null", "body"),
        ("[]", "body"),
        ('{"session_ids": [1', "not JSON"),
        (b"\xff", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ('{"session_ids": ' + "9" * 5000 + "}", "not JSON"),
    ],
)
async def test_sessions_named_wrongly_are_refused_in_one_sentence(client, body, what):
    refused = await client.post(CAMPAIGNS, content=body, headers={"Content-Type": "application/json"})

    assert refused.status_code == 422
    assert what in refused.json()["detail"]


async def test_sessions_that_are_not_there_make_no_campaign(client):
    refused = await client.post(CAMPAIGNS, json={"session_ids": [7]})

    assert refused.status_code == 404


async def test_a_client_that_goes_away_ends_the_reading_and_nothing_is_stored(app, client):
    waiting = Waiting()
    app.state.context.campaign_desk.uploads = Uploads(waiting)
    leaving = LeavingClient(app, CAMPAIGNS, b"PK", "application/zip")
    async with asyncio.timeout(HANGS_S):
        await waiting.begun.wait()

    await leaving.leave()

    assert waiting.ended.is_set()
    assert (await client.get(CAMPAIGNS)).json() == []


async def test_where_too_many_uploads_wait_the_next_one_is_asked_to_come_again(app, client):
    uploads = app.state.context.campaign_desk.uploads
    async with contextlib.AsyncExitStack() as held:
        for _ in range(2):
            await held.enter_async_context(uploads.turn())
        waiting = [asyncio.create_task(held_turn(uploads)) for _ in range(4)]
        await asyncio.sleep(0)

        refused = await client.post(CAMPAIGNS, content=b"PK", headers=ZIP)

        for task in waiting:
            task.cancel()
    assert refused.status_code == 503
    assert int(refused.headers["Retry-After"]) > 0
    assert "Too many requests of this kind are waiting already" in refused.json()["detail"]


async def held_turn(uploads):
    async with uploads.turn():
        await asyncio.Event().wait()


async def test_an_upload_that_was_stored_is_not_read_again_for_its_key(app, client):
    sent = {"content": ARCHIVE, "headers": {**ZIP, "Idempotency-Key": "u-1"}}
    first = await client.post(CAMPAIGNS, **sent)
    app.state.context.campaign_desk.uploads = Uploads(Waiting())

    again = await client.post(CAMPAIGNS, **sent)

    assert again.json() == first.json()
