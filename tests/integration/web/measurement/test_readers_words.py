"""What a session says is kept as a message, and answered in the words of whoever asks."""

import json

import pytest
from sqlalchemy import text

from tests.helpers.web.clients import command
from tests.integration.web.bench import planned
from truepose.messages.catalogue import catalogue
from truepose.sessions.engine.prompts import CELL_CLEAR
from truepose.storage.tables import session_states

IN_INCHES = {"Accept-Language": "de-CH, en;q=0.5", "Cookie": "units=inch-deg-c"}


async def asked(client, headers=None):
    """Return a session that asks a person to look at the cell."""
    path = await planned(client, n=3)
    await command(client, path, "start")
    return path, (await client.get(path, headers=headers)).json()


async def test_whoever_names_no_language_is_answered_in_english(client):
    _, session = await asked(client)

    assert session["prompt"]["message"].endswith(catalogue("en").spoken(CELL_CLEAR))
    assert session["reason"] == session["prompt"]["message"]


@pytest.mark.parametrize(("accepted", "language"), [("fr", "fr"), ("ja;q=0.9, xx", "ja"), ("xx", "en")])
async def test_a_session_asks_in_the_language_that_is_preferred(client, accepted, language):
    _, session = await asked(client, {"Accept-Language": accepted})

    assert session["prompt"]["message"].endswith(catalogue(language).spoken(CELL_CLEAR))


async def test_figures_of_a_sentence_are_in_the_units_of_whoever_reads(client):
    _, session = await asked(client, IN_INCHES)

    assert (
        "höchstens 9,84252 in/s, bis" in session["prompt"]["message"]
    )  # 250 mm/s before a first session has finished


async def test_a_refusal_and_what_it_means_are_in_one_language(client):
    path, _ = await asked(client)

    said = {"command": "resume", "person": "Ada"}
    refused = await client.post(f"{path}/commands", json=said, headers={"Accept-Language": "de"})

    problem = refused.json()
    assert refused.status_code == 409
    assert problem["detail"].startswith("Die Sitzung ")
    assert problem["meaning"] == catalogue("de").say(f"error.{problem['code']}.data")


async def test_events_tell_messages_in_the_words_of_whoever_follows(client):
    path, _ = await asked(client)
    number = path.rpartition("/")[2]

    told = await client.get(
        "/api/v1/events",
        params={"session_id": number, "stop_after_s": 0.5},
        headers={"Accept-Language": "es"},
    )

    reasons = [
        json.loads(line[6:]).get("reason", "") for line in told.text.splitlines() if line[:5] == "data:"
    ]
    assert any(reason.endswith(catalogue("es").spoken(CELL_CLEAR)) for reason in reasons)


async def test_a_pause_is_told_by_its_key_in_every_language(client):
    path, _ = await asked(client)
    await command(client, path, "abort")

    session = (await client.get(path, headers={"Accept-Language": "zh"})).json()

    assert session["reason_key"] == "session.end_asked"
    assert session["reason"] == catalogue("zh").say("session.end_asked")


async def test_what_is_kept_is_no_sentence_of_any_language(client, app):
    await asked(client)

    kept = await app.state.context.database.read(
        lambda connection: list(connection.scalars(text("SELECT reason FROM session_states")))
    )

    assert [json.loads(reason)["key"] for reason in kept] == ["session.plan_stored", "sentences"]


async def test_a_sentence_that_was_kept_before_there_were_messages_stays_as_it_is(client, app):
    path, _ = await asked(client)
    number, before = int(path.rpartition("/")[2]), "Paused on request. Is the cell clear?"
    row = {"session_id": number, "recorded_at": "2026-01-01T00:00:00.000+00:00", "state": "aborted"}
    await app.state.context.database.write(
        lambda connection: connection.execute(session_states.insert().values(**row, reason=before))
    )

    states = (await client.get(path, headers={"Accept-Language": "fr"})).json()["states"]

    assert states[-1]["reason"] == before
