"""Clients of an application in this process, without a network between them."""

import asyncio
import contextlib

import httpx

from tests.helpers.machine import HANGS_S
from truepose.app import create_app

ENDED = {"succeeded", "failed"}
ANSWERS = {"confirm", "resume"}


def client_of(app, peer="127.0.0.1"):
    transport = httpx.ASGITransport(app, client=(peer, 50123))
    return httpx.AsyncClient(transport=transport, base_url="http://localhost", timeout=60)


@contextlib.asynccontextmanager
async def served(*pieces):
    """A client of a service that begins and ends here."""
    app = create_app(*pieces)
    async with app.router.lifespan_context(app), client_of(app) as client:
        yield client


async def until(client, path, condition):
    """Ask a resource until it is as it should be, and return it."""
    async with asyncio.timeout(HANGS_S):
        while not condition(found := (await client.get(path)).json()):
            await asyncio.sleep(0.05)
    return found


async def made(client, accepted):
    """Return where the result of a job is that was just accepted, once it is there."""
    assert accepted.status_code == 202, accepted.text
    job = await until(client, accepted.headers["Location"], lambda job: job["state"] in ENDED)
    assert job["state"] == "succeeded", job["message"]
    return job["result_url"]


def prompt_id(session):
    """Return the number of what is asked, as an answer names it; None where nothing is."""
    return (session.get("prompt") or {}).get("id")


async def command(client, path, name, key=None, **said):
    """Ask something of a session as Ada would, naming the question that is open where it may be an answer."""
    body = {"command": name, "person": "Ada", **said}
    if name in ANSWERS and "prompt_id" not in said:
        body["prompt_id"] = prompt_id((await client.get(f"{path}/situation")).json())
    headers = {} if key is None else {"Idempotency-Key": key}
    return await client.post(f"{path}/commands", json=body, headers=headers)


async def measured(client, wanted):
    """Plan a session, have Ada confirm it, and return its path and number once it has finished."""
    path = await made(client, await client.post("/api/v1/sessions", json=wanted))
    await command(client, path, "start")
    await until(client, path, lambda session: session["state"] == "awaiting_confirmation")
    await command(client, path, "confirm")
    session = await until(client, path, lambda session: session["state"] in {"finished", "faulted"})
    assert session["state"] == "finished", session["reason"]
    return path, session["id"]
