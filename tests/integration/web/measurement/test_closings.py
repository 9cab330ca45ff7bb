"""Closing a session as calibrated: on certificates that hold, or by a named person for a reason."""

import pytest

from tests.helpers.web.clients import command
from tests.integration.web.bench import measured, planned

REASON = "The laboratory returns the report on Monday; the scale bar was measured today."


@pytest.fixture
async def finished(client, until):
    """A session that has finished; the bench's tracker has a certificate without a day of expiry."""
    return await measured(client, until)


async def close(client, path, **changes):
    return await client.post(f"{path}/closing", json={"closed_as": "calibrated", "person": "Ada"} | changes)


async def test_nobody_closes_as_calibrated_without_a_certificate_or_a_reason(client, finished):
    refused = [await close(client, finished), await close(client, finished, reason="   ")]
    shown = (await client.get(f"{finished}/closing")).json()

    for answer in refused:
        assert answer.status_code == 409
        sentence = answer.json()["detail"]
        assert "The certificate of the laser tracker, serial number 42 states no expiry date" in sentence
        assert "A named person may still close the session with a reason" in sentence
    assert shown["closed_as"] == "open"
    assert [(one["what"], one["standing"]) for one in shown["certificates"]] == [("laser tracker", "undated")]


async def test_a_named_person_may_for_a_reason_and_only_once(client, finished):
    closed = await close(client, finished, reason=REASON)
    again = await close(client, finished, reason="Better so.")
    shown = (await client.get(f"{finished}/closing")).json()

    assert closed.status_code == 201, closed.text
    assert (shown["closed_as"], shown["person"], shown["reason"]) == ("calibrated", "Ada", REASON)
    assert shown == closed.json()
    assert again.status_code == 409
    assert "closed as calibrated already" in again.json()["detail"]


async def test_who_claims_nothing_needs_no_certificate(client, finished):
    closed = await close(client, finished, closed_as="not calibrated")

    assert closed.status_code == 201
    assert closed.json()["closed_as"] == "not calibrated"


async def test_what_did_not_finish_is_not_closed_as_calibrated(client):
    path = await planned(client)

    going_on = await close(client, path, reason=REASON)
    await command(client, path, "abort")
    broken_off = await close(client, path, reason=REASON)
    disclaimed = await close(client, path, closed_as="not calibrated")

    assert going_on.status_code == 409
    assert "close it after it has ended" in going_on.json()["detail"]
    assert broken_off.status_code == 409
    assert disclaimed.status_code == 201


async def test_a_session_that_is_none_is_not_closed(client):
    assert (await close(client, "/api/v1/sessions/99", reason=REASON)).status_code == 404
