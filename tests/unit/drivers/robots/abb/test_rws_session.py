"""A session with web services, against a scripted server that lives in memory."""

import asyncio
import json

import pytest

from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.abb_rws import protocol
from truepose_drivers.abb_rws.conversation import RwsSession
from truepose_drivers.abb_rws.http import (
    LONGEST_BODY_BYTES,
    Challenge,
    HttpResponse,
    Login,
    RequestReader,
    challenge_header,
    encode_response,
    is_let_in,
)
from truepose_drivers.errors import ConnectionLostError, DeviceRefusedError, NoReplyError, RemoteProtocolError

pytestmark = pytest.mark.simulated_time

LOGIN = Login("Default User", "robotics")
JOINTS = {"_type": "ms-jointtarget", **{f"rax_{joint}": str(joint) for joint in range(1, 7)}}
COOKIES = (("set-cookie", "-http-session-=8::http.session::d5ae; path=/"), ("set-cookie", "ABBCX=57; path=/"))

ENDLESS = b"HTTP/1.1 200 OK\r\ncontent-length: 4000000\r\n\r\n" + bytes(LONGEST_BODY_BYTES + 1)


class FakeServer:
    """Asks for a digest, then answers every question with `said`; keeps what was asked."""

    def __init__(self, said=None) -> None:
        self.nonce = "first"
        self.said = encode_response(self.joints()) if said is None else said
        self.asked: list = []
        self.connections = 0
        self.on_answer = lambda: None

    @staticmethod
    def joints(*headers) -> HttpResponse:
        body = json.dumps({"_embedded": {"_state": [JOINTS]}}).encode()
        return HttpResponse(200, (*COOKIES, *headers), body)

    async def serve(self, end: MemoryEnd) -> None:
        self.connections += 1
        requests = RequestReader()
        while data := await end.receive():
            requests.receive_data(data)
            while (request := requests.next_message()) is not None:
                self.asked.append(request)
                await end.send(self._answer(request))
                self.on_answer()

    def _answer(self, request) -> bytes:
        challenge = Challenge("here", self.nonce)
        header = request.headers.get("authorization", "")
        if is_let_in(header, challenge, LOGIN, request.method, request.target):
            return self.said
        return encode_response(HttpResponse(401, (("www-authenticate", challenge_header(challenge)),)))


async def opened(server: FakeServer, chunk_bytes: int = 65_536) -> RwsSession:
    session = RwsSession(MemoryLink(server.serve, chunk_bytes=chunk_bytes), LOGIN)
    await session.open()
    return session


@pytest.fixture
def server():
    return FakeServer()


@pytest.fixture
async def session(server):
    return await opened(server)


async def joints(session: RwsSession):
    return await session.get(protocol.JOINT_TARGET, protocol.joint_angles_deg)


async def test_a_challenge_is_answered_once_and_kept_with_counted_requests(server):
    session = await opened(server, chunk_bytes=13)

    for _ in range(3):
        assert await joints(session) == (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)

    counts = [request.headers.get("authorization", "")[-38:] for request in server.asked]
    assert [("nc=0000000" + str(n)) in count for n, count in enumerate(counts)] == [False, True, True, True]
    assert "cookie" not in server.asked[1].headers
    assert server.asked[2].headers["cookie"] == "-http-session-=8::http.session::d5ae; ABBCX=57"


async def test_a_challenge_that_grew_old_is_answered_anew(server, session):
    await joints(session)
    server.nonce = "second"

    assert await joints(session)
    assert session.is_open


async def test_a_connection_that_the_server_ends_is_opened_again_before_the_next_question():
    server = FakeServer(encode_response(FakeServer.joints(("connection", "close"))))
    session = await opened(server)

    for _ in range(3):
        assert await joints(session)

    assert server.connections == 3
    assert server.asked[-1].headers["cookie"].endswith("ABBCX=57")


async def test_a_connection_that_is_gone_is_not_opened_again_unseen(server, session):
    await joints(session)
    await session.close()

    with pytest.raises(ConnectionLostError, match="connect first"):
        await joints(session)
    assert server.connections == 1


@pytest.mark.parametrize(
    ("said", "match"),
    [
        (encode_response(FakeServer.joints()) + b"HTTP/1.1 200 OK\r\n", "more data than requested"),
        (ENDLESS, "more than 1048576"),
        (b"4 1 10.00 20.00 30.00 40.00 50.00 60.00\r\n\r\n", "not HTTP"),
        (encode_response(HttpResponse(200, (), b"<html>")), "not JSON"),
    ],
)  # fmt: skip
async def test_nonsense_closes_the_link(said, match):
    server = FakeServer(said)
    session = await opened(server)

    with pytest.raises(RemoteProtocolError, match=match):
        await joints(session)
    assert not session.is_open


@pytest.mark.parametrize("said", [b"", b"HTTP/1.1 200 OK\r\ncontent-length: 10\r\n\r\n{"])
async def test_silence_is_told_within_two_seconds_and_closes_the_link(said):
    session = await opened(FakeServer(said))
    began_s = asyncio.get_running_loop().time()

    with pytest.raises(NoReplyError, match="does not respond"):
        await joints(session)

    assert asyncio.get_running_loop().time() - began_s == pytest.approx(1.5, abs=0.1)
    assert not session.is_open


@pytest.mark.parametrize(
    ("status", "body", "match"),
    [
        (404, b"", r"refused GET /rw/motionsystem/.* \(HTTP status 404\)"),
        (400, protocol.encode_error(-1, "Symbol tgt not found"), "Symbol tgt not found"),
        (503, b"", "too many clients are connected, close some"),
    ],
)
async def test_a_refusal_is_told_and_leaves_the_link_open(status, body, match):
    session = await opened(FakeServer(encode_response(HttpResponse(status, (), body))))

    with pytest.raises(DeviceRefusedError, match=match):
        await joints(session)
    assert session.is_open


async def test_leaving_logs_out_and_never_raises(server, session):
    await session.leave()
    await session.leave()

    assert server.asked[-1].path == "/logout"
    silent = await opened(FakeServer(b""))
    await silent.leave()
    assert not silent.is_open
