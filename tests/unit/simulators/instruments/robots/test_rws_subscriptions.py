"""Subscriptions in exact bytes: the example of RFC 6455, and events as the public client looks for them."""

import asyncio
import re

import pytest

from truepose_drivers.abb_rws.http import HttpRequest, form_body
from truepose_drivers.abb_rws.protocol import ControllerState
from truepose_simulators.instruments.robot.abb_rws.answers import (
    Answers,
    NotFoundError,
    Subscriptions,
    switching,
    text_frame,
)
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController, PublicProgram

pytestmark = pytest.mark.simulated_time

PANEL = "/rw/panel/ctrlstate"
TARGET = "/rw/rapid/symbol/data/RAPID/T_ROB1/tgt;value"


@pytest.fixture
def controller(make_cell):
    found = AbbController(make_cell())
    found.task = PublicProgram(found)
    return found


class Listener:
    def __init__(self):
        self.heard = b""

    def write(self, data):
        self.heard += data

    async def drain(self):
        await asyncio.sleep(0)


def subscribed(controller, *wanted):
    """Subscribe as the public client does; returns all subscriptions."""
    subscriptions = Subscriptions(Answers(controller))
    form = {str(number): resource for number, resource in enumerate(wanted, start=1)}
    form |= {f"{number}-p": "1" for number in form} | {"resources": "1"}
    request = HttpRequest("POST", "/subscription?json=1", {"host": "10.0.0.1"}, form_body(form))
    answer = subscriptions.add(request)
    assert answer.status == 201
    assert re.search(r'<a href="ws:\/\/.*(\/poll\/\d+)" rel="self">', answer.body.decode())[1] == "/poll/1"
    return subscriptions


async def heard(subscriptions, happens, path="/poll/1"):
    reader, listener = asyncio.StreamReader(), Listener()
    telling = asyncio.create_task(subscriptions.tell(path, reader, listener))
    await asyncio.sleep(0.2)
    happens()
    await asyncio.sleep(0.2)
    reader.feed_eof()
    await telling
    return listener.heard


def test_the_handshake_is_that_of_the_standard(controller):
    # RFC 6455, section 1.3
    request = HttpRequest("GET", "/poll/1", {"sec-websocket-key": "dGhlIHNhbXBsZSBub25jZQ=="})

    head = switching(subscribed(controller, PANEL).handshake(request)).decode()

    assert head.startswith("HTTP/1.1 101 Switching Protocols\r\nupgrade: websocket\r\n")
    assert "sec-websocket-accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n" in head
    assert head.endswith("sec-websocket-protocol: robapi2_subscription\r\n\r\n")
    with pytest.raises(NotFoundError, match="only WebSocket connections"):
        subscribed(controller, PANEL).handshake(HttpRequest("GET", "/poll/1"))


def test_texts_are_framed_as_in_the_standard():
    # RFC 6455, section 5.7
    assert text_frame("Hello") == bytes.fromhex("810548656c6c6f")
    assert text_frame("a" * 300)[:4] == bytes.fromhex("817e012c")
    assert text_frame("a" * 70_000)[:10] == bytes.fromhex("817f0000000000011170")


async def test_a_change_is_told_once_as_the_public_client_looks_for_it(controller):
    subscriptions = subscribed(controller, PANEL, TARGET)

    said = await heard(subscriptions, lambda: controller.switch(ControllerState.MOTORS_OFF))

    text = said[2:].decode() if said[1] < 126 else said[4:].decode()
    assert 'li class="pnl-ctrlstate-ev"' in text
    pattern = r'<a\s+href="/rw/panel/ctrlstate"\s+rel="self"/?>.*<span\s+class="ctrlstate">([^<]+)<'
    assert re.search(pattern, text)[1] == "motoroff"
    assert said.count(b"<li") == 1


async def test_a_variable_is_told_by_its_path(controller):
    subscriptions = subscribed(controller, TARGET)

    said = await heard(subscriptions, lambda: controller.write("tgt", "[[1,2,3,4,5,6],[0,0,0,0,0,0]]"))

    pattern = r'/rw/rapid/symbol/data/RAPID/([^"]+);value"\s+rel="self"/?>.*<span\s+class="value">([^<]+)<'
    assert re.search(pattern, said.decode(errors="replace")).groups() == (
        "T_ROB1/tgt",
        "[[1,2,3,4,5,6],[0,0,0,0,0,0]]",
    )


async def test_where_nothing_changes_nothing_is_told(controller):
    assert await heard(subscribed(controller, PANEL, TARGET), lambda: None) == b""
    other = subscribed(controller, PANEL)
    assert await heard(other, lambda: controller.write("go", "1")) == b""


@pytest.mark.parametrize("path", ["/poll/2", "/poll/0", "/poll/-1", "/poll/x", "/poll/\xb2", "/poll/"])
def test_nobody_listens_to_what_was_not_subscribed(controller, path):
    subscriptions = subscribed(controller, PANEL)

    with pytest.raises(NotFoundError, match="subscribed"):
        subscriptions.handshake(HttpRequest("GET", path, {"sec-websocket-key": "x"}))


def test_a_client_that_names_no_host_subscribes_all_the_same(controller):
    request = HttpRequest("POST", "/subscription", {}, form_body({"1": PANEL}))

    answer = Subscriptions(Answers(controller)).add(request)

    assert dict(answer.headers)["location"] == "ws://localhost/poll/1"


async def test_a_target_that_is_none_moves_nothing(controller):
    controller.write("tgt", "[[nowhere]]")
    controller.write("go", "1")
    await asyncio.sleep(0.1)

    assert controller.task._motion.exception() is None
    assert not controller.cell.robot_moves
    controller.write("tgt", "[[1,2,3,4,5,6],[0,0,0,0,0,0]]")
    controller.write("go", "1")
    await asyncio.sleep(0.1)
    assert controller.task.variables["go"] == "0"


@pytest.mark.parametrize(
    "resource", ["/rw/nothing", "/rw/rapid/symbol/data/RAPID/T_ROB1/none;value", "/rw/elog/0/", "/logout"]
)
def test_what_is_not_there_cannot_be_subscribed_to(controller, resource):
    with pytest.raises(NotFoundError):
        subscribed(controller, resource)
