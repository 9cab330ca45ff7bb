"""The web server of a controller: digest authentication, sessions by cookie, JSON."""

import asyncio
import contextlib
import itertools
import secrets

from truepose_drivers.abb_rws import http, protocol
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.abb_rws.answers import (
    POLL,
    Answers,
    NotFoundError,
    Subscriptions,
    switching,
)
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController, RefusedError
from truepose_simulators.instruments.robot.clients import say_to_client

_CHUNK_BYTES = 16_384
_REALM = "validusers@robapi.abb"
_LOGIN = http.Login(protocol.USER, protocol.PASSWORD)
_MOST_SESSIONS = 70
_REQUESTS_PER_CONNECTION = 400
_JSON = ("content-type", "application/json")
_FILES = "/fileservice/"
_SWITCHING = 101
_NOT_FOUND, _NOT_ALLOWED = -1073442807, -1073445865  # codes of the controller's interface


class WebServices:
    """One controller's web services; `answer` knows no socket."""

    def __init__(self, controller: AbbController) -> None:
        self._controller = controller
        self._answers = Answers(controller)
        self.subscriptions = Subscriptions(self._answers)
        self._challenge = http.Challenge(_REALM, secrets.token_hex(16))
        self._numbers = itertools.count(1)
        self._sessions: set[str] = set()

    def answer(self, request: http.HttpRequest) -> http.HttpResponse:
        """Return what a request is answered with."""
        header = request.headers.get("authorization", "")
        if not http.is_let_in(header, self._challenge, _LOGIN, request.method, request.target):
            return http.HttpResponse(401, (("www-authenticate", http.challenge_header(self._challenge)),))
        number, cookies = self._session(request)
        if len(self._sessions) > _MOST_SESSIONS:
            self._sessions.discard(number)
            return http.HttpResponse(503)
        if request.path == protocol.LOGOUT:
            self._sessions.discard(number)
        answered = self._answer(request)
        return http.HttpResponse(answered.status, (*answered.headers, *cookies), answered.body)

    def _session(self, request: http.HttpRequest) -> tuple[str, tuple[tuple[str, str], ...]]:
        """Return the number of the session, and its cookies where it is new."""
        sent = request.headers.get("cookie", "").split(";")
        known = {cookie.strip().removeprefix("ABBCX=") for cookie in sent} & self._sessions
        if known:
            return known.pop(), ()
        number = str(next(self._numbers))
        self._sessions.add(number)
        texts = (f"-http-session-={number}::http.session::{secrets.token_hex(8)}", f"ABBCX={number}")
        return number, tuple(("set-cookie", f"{text}; path=/; httponly") for text in texts)

    def _answer(self, request: http.HttpRequest) -> http.HttpResponse:
        try:
            if request.path.startswith(_FILES):
                return self._file(request)
            if request.path.startswith(POLL):
                return self.subscriptions.handshake(request)
            if (request.method, request.path) == ("POST", "/subscription"):
                return self.subscriptions.add(request)
            if request.method == "GET":
                told = protocol.encode_states(request.path, self._answers.told(request.path))
                return http.HttpResponse(200, (_JSON,), told)
            done = self._answers.done(request)
        except NotFoundError as error:
            return http.HttpResponse(404, (_JSON,), protocol.encode_error(_NOT_FOUND, str(error)))
        except (RefusedError, http.RwsProtocolError, OverflowError) as error:
            return http.HttpResponse(400, (_JSON,), protocol.encode_error(_NOT_ALLOWED, str(error)))
        if done is None:
            return http.HttpResponse(204)
        return http.HttpResponse(200, (_JSON,), protocol.encode_states(request.path, done))

    def _file(self, request: http.HttpRequest) -> http.HttpResponse:
        files, name = self._controller.files, request.path.removeprefix(_FILES)
        if request.method == "PUT":
            files[name] = request.body
            return http.HttpResponse(201)
        if name not in files:
            raise NotFoundError(f"there is no file {name}")
        if request.method == "DELETE":
            del files[name]
            return http.HttpResponse(204)
        return http.HttpResponse(200, (("content-type", "application/octet-stream"),), files[name])


def web_endpoint(cell: Cell, controller: AbbController, device: str = "robot") -> Endpoint:
    """Build the web services of a cell's robot; any number of clients."""
    services = WebServices(controller)

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(http.RwsProtocolError):  # the server hangs up
            await _converse(services, cell, reader, writer)

    return Endpoint(device, "rws", serve)


async def _converse(
    services: WebServices, cell: Cell, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
) -> None:
    requests, answered = http.RequestReader(), 0
    while answered < _REQUESTS_PER_CONNECTION and (data := await reader.read(_CHUNK_BYTES)):
        requests.receive_data(data)
        while (request := requests.next_message()) is not None:
            answer = services.answer(request)
            answered += 1
            if answer.status == _SWITCHING:
                writer.write(switching(answer))
                await services.subscriptions.tell(request.path, reader, writer)
                return
            await say_to_client(cell, writer, http.encode_response(answer))
