"""A page of another site whose name leads here, against a session that waits for its confirmation."""

import socket
import time

import httpx
import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import prompt_id
from tests.integration.web.bench import Bench, session_request
from tests.integration.web.listening import listening
from truepose.app import create_app

SESSION = "/api/v1/sessions/1"
COMMANDS = f"{SESSION}/commands"


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture
def waiting(settings, bench):
    """A client of a service whose session waits for a person."""
    with (
        listening(create_app(settings, bench.registry())) as url,
        httpx.Client(base_url=url, timeout=60) as client,
    ):
        for device in ("tracker", "robot"):
            client.post(f"/api/v1/devices/{device}/connect").raise_for_status()
        client.post("/api/v1/sessions", json=session_request()).raise_for_status()
        commanded(client, "start").raise_for_status()
        end_s = time.monotonic() + HANGS_S
        while client.get("/api/v1/sessions/1").json()["state"] != "awaiting_confirmation":
            assert time.monotonic() < end_s
        yield client


def commanded(client, name, headers=None, person="Ada Byron"):
    # Who is refused has asked nothing before.
    asked = None if headers and "Host" in headers else prompt_id(client.get(f"{SESSION}/situation").json())
    return client.post(
        COMMANDS, json={"command": name, "person": person, "prompt_id": asked}, headers=headers or {}
    )


def foreign(client):
    """What a browser sends of a page at evil.example, as its name leads elsewhere, or here."""
    port = client.base_url.port
    here, there = f"127.0.0.1:{port}", f"evil.example:{port}"
    return [
        {"Host": there, "Origin": f"http://{there}", "Sec-Fetch-Site": "same-origin"},
        {"Host": there, "Origin": f"http://{there}"},
        {"Host": there},
        {"Host": there, "X-Forwarded-Host": here},
        {"Host": here, "Origin": f"http://{there}", "Sec-Fetch-Site": "cross-site"},
        {"Host": here, "Origin": f"http://{there}"},
        {"Host": here, "Origin": "null"},
        {"Host": here, "Referer": f"http://{there}/"},
        {"Host": here, "Sec-Fetch-Site": "cross-site"},
    ]


def test_a_page_of_another_site_confirms_nothing(waiting, bench):
    for headers in foreign(waiting):
        refused = commanded(waiting, "confirm", headers, "Mallory")
        assert refused.status_code in (403, 421), headers

    assert waiting.get("/api/v1/sessions/1").json()["state"] == "awaiting_confirmation"
    assert bench.robot.moves == 0


def test_it_stops_and_reads_nothing_either(waiting):
    for headers in foreign(waiting):
        for name in ("pause", "abort"):
            assert commanded(waiting, name, headers).status_code in (403, 421), headers
    for headers in [entry for entry in foreign(waiting) if "Referer" not in entry]:
        for path in ("/api/v1/sessions/1", "/api/v1/events", "/operator", "/static/tablet/common/tablet.css"):
            assert waiting.get(path, headers=headers).status_code in (403, 421), headers

    assert waiting.get("/api/v1/sessions/1").json()["state"] == "awaiting_confirmation"


def test_a_person_and_a_script_confirm_as_ever(waiting):
    origin = str(waiting.base_url).rstrip("/")

    assert commanded(waiting, "confirm", {"Origin": origin}).is_success


@pytest.mark.parametrize("late_s", [0.0, 0.2])
def test_a_refusal_arrives_whole_though_the_body_comes_after_it(waiting, late_s):
    place, body = (waiting.base_url.host, waiting.base_url.port), b'{"command": "abort"}'
    head = (
        f"POST {COMMANDS} HTTP/1.1\r\nHost: evil.example\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(body)}\r\n\r\n"
    )

    with socket.create_connection(place, timeout=HANGS_S) as wire:
        wire.sendall(head.encode())
        time.sleep(late_s)
        wire.sendall(body)
        time.sleep(late_s)
        wire.sendall(b"")
        answer = b"".join(iter(lambda: wire.recv(65_536), b""))

    assert answer.startswith(b"HTTP/1.1 421 ")
    assert answer.endswith(b"}")


def test_a_refusal_waits_for_no_body_that_does_not_come(waiting):
    place = (waiting.base_url.host, waiting.base_url.port)
    head = f"POST {COMMANDS} HTTP/1.1\r\nHost: evil.example\r\nContent-Length: 20\r\n\r\n"

    with socket.create_connection(place, timeout=HANGS_S) as wire:
        wire.sendall(head.encode())
        answer = b"".join(iter(lambda: wire.recv(65_536), b""))

    assert answer.startswith(b"HTTP/1.1 421 ")
