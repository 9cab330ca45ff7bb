"""Digest authentication with MD5 (RFC 2617), the way in to Robot Web Services."""

import hashlib
import re
from dataclasses import dataclass
from typing import Final

from truepose_drivers.abb_rws.protocol.errors import RwsProtocolError

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
        raise RwsProtocolError(f"{(header or '')[:80]!r} asks for another way in than Digest with MD5")
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
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()


def _pairs(text: str) -> dict[str, str]:
    return {name.lower(): quoted or plain for name, quoted, plain in _PAIR.findall(text)}
