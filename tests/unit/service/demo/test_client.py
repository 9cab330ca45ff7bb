"""What the runs make of the service's answers."""

import json

import httpx
import pytest

from truepose.demo.client import ServiceClient, open_client
from truepose.demo.errors import JobFailedError, RequestRefusedError, ServiceFailedError, SessionHaltedError


def stream(*events):
    """Server-sent events as the service writes them."""
    texts = [
        f"id: {number}\nevent: {kind}\ndata: {json.dumps(document)}\n\n"
        for number, (kind, document) in enumerate(events, start=1)
    ]
    return "retry: 1000\n\n" + ": still here\n\n".join(texts)


def state(name, reason="because"):
    return "session.state", {"state": name, "reason": reason, "person": None}


def client_of(*events):
    """A client whose service answers every POST, asks question 1 of a session, and has these events."""

    def answer(request):
        if request.url.path == "/api/v1/events":
            return httpx.Response(200, text=stream(*events))
        if request.url.path == "/api/v1/sessions/1/situation":
            return httpx.Response(200, json={"prompt": {"id": 1}})
        return httpx.Response(202, json={"id": 1})

    return ServiceClient(httpx.AsyncClient(transport=httpx.MockTransport(answer), base_url="http://service"))


def silent(done, planned, doing):
    pass


BEGIN = (state("planned"), state("awaiting_confirmation"), state("running"))


async def test_a_session_is_followed_to_its_end():
    told = []
    progress = {"done": 3, "skipped": 1, "planned": 5, "doing": "measuring configuration 5"}
    client = client_of(*BEGIN, ("session.progress", progress), state("finished"))

    await client.run_session(1, lambda *what: told.append(what))

    assert told == [(4, 5, "measuring configuration 5")]


@pytest.mark.parametrize("halt", ["paused", "awaiting_confirmation", "aborted", "failed"])
async def test_a_session_that_stands_still_is_an_error_with_its_reason(halt):
    client = client_of(*BEGIN, state(halt, "The link to the tracker was lost."))

    with pytest.raises(SessionHaltedError, match="The link to the tracker was lost"):
        await client.run_session(1, silent)


async def test_events_that_end_too_early_are_an_error():
    with pytest.raises(ServiceFailedError):
        await client_of(*BEGIN).run_session(1, silent)


async def test_a_job_gives_the_number_of_what_it_made():
    progress = ("job.progress", {"fraction": 0.5, "doing": "identifying"})
    ended = ("job.state", {"state": "succeeded", "message": "Done.", "result_id": 12})

    assert await client_of(progress, ended).finish_job(7, silent) == 12


async def test_a_job_that_fails_is_an_error_with_its_sentence():
    ended = ("job.state", {"state": "failed", "message": "There are too few readings.", "result_id": None})

    with pytest.raises(JobFailedError, match="too few readings"):
        await client_of(ended).finish_job(7, silent)


async def test_a_refused_request_is_an_error_with_the_services_sentence():
    def refuse(request):
        return httpx.Response(409, json={"status": 409, "detail": "Session 1 holds the devices."})

    http = httpx.AsyncClient(transport=httpx.MockTransport(refuse), base_url="http://service")

    with pytest.raises(RequestRefusedError, match="Session 1 holds the devices"):
        await ServiceClient(http).identify(1)


async def test_a_service_that_is_gone_is_said_with_its_address():
    with pytest.raises(ServiceFailedError, match=r"127\.0\.0\.1:9"):  # the discard port: nobody listens
        async with open_client("http://127.0.0.1:9") as client:
            await client.get("/cells")
