"""HTTP/1.1 with digest authentication, as far as Robot Web Services need it; the framing is h11's.

Digest authentication with MD5 (RFC 2617) is the way in. A reader takes one message of the other side after
the other; bodies are short, and whole or none.
"""

import hashlib
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, Generic, TypeVar
from urllib.parse import SplitResult, parse_qsl, urlencode, urlsplit

import h11

from truepose_drivers.errors import RemoteProtocolError


class RwsProtocolError(RemoteProtocolError):
    """The other side sent what is no message of Robot Web Services."""


_PAIR: Final = re.compile(r'([a-z]+)\s*=\s*(?:"([^"]*)"|([^\s,"]+))', re.IGNORECASE)
_QOP: Final = "auth"


@dataclass(frozen=True, slots=True)
class Challenge:
    """What a server asks whoever wants in; `qop` is empty where it knows none."""

    realm: str
    nonce: str
    qop: str = _QOP


@dataclass(frozen=True, slots=True)
class Login:
    """Who wants in."""

    user: str
    password: str


def challenge_header(challenge: Challenge) -> str:
    """Return the header `WWW-Authenticate` of a challenge."""
    return f'Digest realm="{challenge.realm}", qop="{challenge.qop}", nonce="{challenge.nonce}"'


def decode_challenge(header: str | None) -> Challenge:
    """Read the header `WWW-Authenticate`; raises RwsProtocolError."""
    scheme, _, rest = (header or "").partition(" ")
    told = _pairs(rest)
    offered = [word.strip() for word in told.get("qop", "").split(",")]
    said = (header or "").isascii() and (header or "").isprintable()
    known = said and scheme.lower() == "digest" and told.get("algorithm", "MD5").upper() == "MD5"
    if not (known and "nonce" in told and {"", _QOP} & set(offered)):
        raise RwsProtocolError(f"{(header or '')[:80]!r} does not offer Digest authentication with MD5")
    return Challenge(told.get("realm", ""), told["nonce"], _QOP if _QOP in offered else "")


def authorization(
    challenge: Challenge, login: Login, method: str, target: str, *, count: int, client_nonce: str
) -> str:
    """Return the header `Authorization` of the request number `count` to a challenge."""
    answer = _answer(challenge, login, method, target, f"{count:08x}", client_nonce)
    said = (
        f'Digest username="{login.user}", realm="{challenge.realm}", nonce="{challenge.nonce}",'
        f' uri="{target}", response="{answer}"'
    )
    if not challenge.qop:
        return said
    return f'{said}, qop={challenge.qop}, nc={count:08x}, cnonce="{client_nonce}"'


def is_let_in(header: str, challenge: Challenge, login: Login, method: str, target: str) -> bool:
    """Whether the header `Authorization` of a request answers a challenge."""
    told = _pairs(header.partition(" ")[2])
    answer = _answer(challenge, login, method, target, told.get("nc", ""), told.get("cnonce", ""))
    claimed = (told.get("username"), told.get("nonce"), told.get("uri"), told.get("response"))
    return claimed == (login.user, challenge.nonce, target, answer)


def _answer(
    challenge: Challenge, login: Login, method: str, target: str, count: str, client_nonce: str
) -> str:
    who = _hash(f"{login.user}:{challenge.realm}:{login.password}")
    what = _hash(f"{method}:{target}")
    once = f"{challenge.nonce}:{count}:{client_nonce}:{challenge.qop}" if challenge.qop else challenge.nonce
    return _hash(f"{who}:{once}:{what}")


def _hash(text: str) -> str:
    # Controllers ask for MD5. Stated as not for security, it runs on systems that bar it elsewhere too.
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()


def _pairs(text: str) -> dict[str, str]:
    return {name.lower(): quoted or plain for name, quoted, plain in _PAIR.findall(text)}


_LONGEST_HEAD_BYTES: Final = 16_384
LONGEST_BODY_BYTES: Final = 1 << 20
# The two that make a session; values as far as they can be sent back.
_COOKIE: Final = re.compile(r"(?P<name>-http-session-|ABBCX)=(?P<value>[!-:<-~]*)")
_FORM: Final = "application/x-www-form-urlencoded"

Message = TypeVar("Message")


@dataclass(frozen=True, slots=True)
class HttpRequest:
    """What a client asks."""

    method: str
    target: str  # path and query, as they stand on the wire
    headers: Mapping[str, str] = field(default_factory=dict)  # names in small letters
    body: bytes = b""

    @property
    def path(self) -> str:
        """The target without its query; raises RwsProtocolError."""
        return self._split.path

    @property
    def query(self) -> dict[str, str]:
        """Parameters of the target; raises RwsProtocolError."""
        return dict(parse_qsl(self._split.query, keep_blank_values=True))

    @property
    def _split(self) -> SplitResult:
        try:
            return urlsplit(self.target)
        except ValueError as error:  # of what looks like an address in brackets
            raise RwsProtocolError(f"{self.target[:40]!r} is not a request target: {error}") from error

    @property
    def form(self) -> dict[str, str]:
        """Parameters of the body; raises RwsProtocolError."""
        try:
            return dict(parse_qsl(self.body.decode(), keep_blank_values=True, max_num_fields=100))
        except ValueError as error:
            raise RwsProtocolError(f"{self.body[:40]!r} is not a form") from error


@dataclass(frozen=True, slots=True)
class HttpResponse:
    """What a server answers."""

    status: int
    headers: tuple[tuple[str, str], ...] = ()  # names in small letters; one may stand there twice
    body: bytes = b""

    def header(self, name: str) -> str | None:
        """Return the first header of a name."""
        return next((value for found, value in self.headers if found == name), None)

    @property
    def ends_connection(self) -> bool:
        """Whether the server says that it closes the connection behind this."""
        return (self.header("connection") or "").lower() == "close"

    @property
    def cookies(self) -> dict[str, str]:
        """The session's cookies, where the server sets them here."""
        set_here = [value for name, value in self.headers if name == "set-cookie"]
        found = (_COOKIE.match(value) for value in set_here)
        return {cookie["name"]: cookie["value"] for cookie in found if cookie is not None}


def form_body(form: Mapping[str, str]) -> bytes:
    """Return the body of a form."""
    return urlencode(form).encode()


def encode_request(request: HttpRequest, host: str) -> bytes:
    """Return the bytes of a request; raises ValueError for a header that cannot be sent."""
    headers = {"host": host, "accept-encoding": "identity", **request.headers}
    if request.method == "POST":
        headers |= {"content-type": _FORM, "content-length": str(len(request.body))}
    wire = h11.Connection(h11.CLIENT)
    try:
        head = h11.Request(method=request.method, target=request.target, headers=list(headers.items()))
    except h11.LocalProtocolError as error:
        raise ValueError(str(error)[:40]) from error
    return _sent(wire, head, request.body)


def encode_response(response: HttpResponse) -> bytes:
    """Return the bytes of a response, which states the length of its body."""
    length = [] if response.status == 204 else [("content-length", str(len(response.body)))]
    wire = h11.Connection(h11.SERVER)
    wire.receive_data(b"GET / HTTP/1.1\r\nhost: any\r\n\r\n")  # which h11 must have heard
    wire.next_event(), wire.next_event()
    head = h11.Response(status_code=response.status, headers=[*response.headers, *length])
    return _sent(wire, head, response.body)


def _sent(wire: h11.Connection, head: h11.Request | h11.Response, body: bytes) -> bytes:
    parts: list[h11.Event] = [head, *([h11.Data(data=body)] if body else []), h11.EndOfMessage()]
    return b"".join(wire.send(part) or b"" for part in parts)


class _MessageReader(Generic[Message]):
    """Collects one message after the other; each has an h11 connection of its own that is ready to hear."""

    def __init__(
        self,
        new_wire: Callable[[], h11.Connection],
        whole: Callable[[h11.Request | h11.Response, bytes], Message],
    ) -> None:
        self._new_wire = new_wire
        self._whole = whole
        self._begin(b"")

    def _begin(self, data: bytes) -> None:
        self._wire: h11.Connection | None = None  # made for the first byte: readers are cheap to throw away
        self._head: h11.Request | h11.Response | None = None
        self._body = b""
        self.receive_data(data)

    @property
    def inside_message(self) -> bool:
        """Whether more stands here than was taken."""
        return self._wire is not None

    def receive_data(self, data: bytes) -> None:
        """Append what arrived."""
        if data:
            self._wire = self._wire or self._new_wire()
            self._wire.receive_data(data)

    def next_message(self) -> Message | None:
        """Take the oldest whole message, None until more arrives; raises RwsProtocolError."""
        if self._wire is None:
            return None
        try:
            while (event := self._wire.next_event()) not in (h11.NEED_DATA, h11.PAUSED):
                if isinstance(event, h11.EndOfMessage):
                    return self._end(self._wire.trailing_data[0])
                self._take(event)
        except h11.RemoteProtocolError as error:
            raise RwsProtocolError(f"the reply is not HTTP ({error}): is this the right port?") from error
        return None

    def _take(self, event: object) -> None:
        if isinstance(event, h11.Request | h11.Response):
            self._head = event
        elif isinstance(event, h11.Data):
            self._body += bytes(event.data)
        if len(self._body) > LONGEST_BODY_BYTES:
            raise RwsProtocolError(f"a message has more than {LONGEST_BODY_BYTES} bytes: connect again")

    def _end(self, behind: bytes) -> Message:
        head, body = self._head, self._body
        if head is None:  # h11 ends nothing that has not begun
            raise RwsProtocolError("a message ended before it began: connect again")
        self._begin(behind)
        return self._whole(head, body)


class ResponseReader(_MessageReader[HttpResponse]):
    """Takes apart what a server answers."""

    def __init__(self) -> None:
        super().__init__(_asking, _response)


class RequestReader(_MessageReader[HttpRequest]):
    """Takes apart what a client asks."""

    def __init__(self) -> None:
        super().__init__(_listening, _request)


def _asking() -> h11.Connection:
    """Return a connection on which a question was asked: only then h11 hears an answer."""
    wire = h11.Connection(h11.CLIENT, max_incomplete_event_size=_LONGEST_HEAD_BYTES)
    wire.send(h11.Request(method="GET", target="/", headers=[("host", "any")]))
    wire.send(h11.EndOfMessage())
    return wire


def _listening() -> h11.Connection:
    return h11.Connection(h11.SERVER, max_incomplete_event_size=_LONGEST_HEAD_BYTES)


def _response(head: h11.Request | h11.Response, body: bytes) -> HttpResponse:
    status = head.status_code if isinstance(head, h11.Response) else 0
    return HttpResponse(status, tuple(_texts(head.headers)), body)


def _request(head: h11.Request | h11.Response, body: bytes) -> HttpRequest:
    method, target = (head.method, head.target) if isinstance(head, h11.Request) else (b"", b"")
    return HttpRequest(method.decode("ascii"), target.decode("latin-1"), dict(_texts(head.headers)), body)


def _texts(headers: Iterable[tuple[bytes, bytes]]) -> list[tuple[str, str]]:
    return [(name.decode("ascii"), value.decode("latin-1")) for name, value in headers]
