"""Ways past the gate that others have tried elsewhere: none of them lets anybody in."""

import pytest
import pytest_asyncio

from tests.helpers.web.routes import asked
from truepose.domain.people import Role
from truepose.people.secrets import new_secret

pytestmark = pytest.mark.asyncio(loop_scope="module")
HOST = ("host", "localhost")
ORIGIN = ("origin", "http://localhost")
KEPT_OUT = {400, 401, 403}


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def secrets(house):
    """What was good once, or elsewhere."""
    accounts = house.here.accounts
    grace = house.people[Role.METROLOGIST]
    _, expired = await accounts.make_token(grace, "expired", Role.METROLOGIST, -1, "a test")
    revoked, gone = await accounts.make_token(grace, "revoked", Role.METROLOGIST, 1, "a test")
    await accounts.register.revoke(revoked.id, by="a test")
    removed = await accounts.register.enter("Mallory", Role.METROLOGIST, "a test")
    _, of_removed = await accounts.make_token(removed, "of nobody", Role.METROLOGIST, 1, "a test")
    old = await accounts.sign_ins.opened(removed, "")
    await accounts.register.remove(removed, "a test")
    signed_out = await accounts.sign_ins.opened(grace, "")
    await accounts.sign_ins.sign_out(signed_out.caller)
    _, watch = await accounts.make_watch_link(1, 1, signed_out.caller)
    invited = await accounts.register.enter("Eve", Role.VIEWER, "a test")
    link = await accounts.link(invited, "a test")
    present = await accounts.sign_ins.opened(grace, "")
    return {
        "good": house.tokens[Role.METROLOGIST],
        "expired": expired,
        "revoked": gone,
        "of_removed": of_removed,
        "cookie_of_removed": old.secret,
        "signed_out": signed_out.secret,
        "watch": watch,
        "link": link,
        "cookie": present.secret,
        "elsewhere": new_secret(),  # as another installation gave it
    }


HEADERS = {
    "nothing": [],
    "empty": [("authorization", "")],
    "blank": [("authorization", " ")],
    "scheme alone": [("authorization", "Bearer")],
    "scheme and blanks": [("authorization", "Bearer   ")],
    "no scheme": [("authorization", "{good}")],
    "basic": [("authorization", "Basic {good}")],
    "digest": [("authorization", 'Digest username="{good}"')],
    "negotiate": [("authorization", "Negotiate {good}")],
    "token": [("authorization", "Token {good}")],
    "two schemes": [("authorization", "Bearer Bearer {good}")],
    "no blank": [("authorization", "Bearer{good}")],
    "tabulator": [("authorization", "Bearer\t{good}")],
    "colon": [("authorization", "Bearer:{good}")],
    "quoted": [("authorization", 'Bearer "{good}"')],
    "comma": [("authorization", "Bearer {good}, Bearer {good}")],
    "twice": [("authorization", "Bearer {good}"), ("authorization", "Bearer {good}")],
    "good and bad": [("authorization", "Bearer {good}"), ("authorization", "Bearer x")],
    "bad and good": [("authorization", "Bearer x"), ("authorization", "Bearer {good}")],
    "cookie and token": [("authorization", "Bearer {good}"), ("cookie", "truepose_sign_in={cookie}")],
    "other case": [("authorization", "Bearer {good_swapped}")],
    "shorter": [("authorization", "Bearer {good_shorter}")],
    "longer": [("authorization", "Bearer {good}A")],
    "null byte": [("authorization", "Bearer {good}\x00")],
    "null byte before": [("authorization", "Bearer \x00{good}")],
    "line feed": [("authorization", "Bearer {good}\nX: y")],
    "header in header": [("authorization", "Bearer x\r\nAuthorization: Bearer {good}")],
    "not ASCII": [("authorization", "Bearer \xe9{good_shorter}")],
    "percent": [("authorization", "Bearer %20{good}")],
    "wildcard": [("authorization", "Bearer *")],
    "null": [("authorization", "Bearer null")],
    "undefined": [("authorization", "Bearer undefined")],
    "its hash": [("authorization", "Bearer {good_hash}")],
    "very long": [("authorization", "Bearer " + "A" * 60_000)],
    "SQL": [("authorization", "Bearer ' OR '1'='1")],
    "expired": [("authorization", "Bearer {expired}")],
    "revoked": [("authorization", "Bearer {revoked}")],
    "of one who was removed": [("authorization", "Bearer {of_removed}")],
    "another installation's": [("authorization", "Bearer {elsewhere}")],
    "a cookie as token": [("authorization", "Bearer {cookie}")],
    "a watch link as token": [("authorization", "Bearer {watch}")],
    "a link as token": [("authorization", "Bearer {link}")],
    "proxy's header": [("proxy-authorization", "Bearer {good}")],
    "another header": [("x-api-key", "{good}")],
    "who it is": [("x-forwarded-user", "Ada Byron"), ("remote-user", "Ada Byron")],
    "from this computer": [("x-forwarded-for", "127.0.0.1"), ("x-real-ip", "127.0.0.1")],
    "a token as cookie": [("cookie", "truepose_sign_in={good}")],
    "a watch link as cookie": [("cookie", "truepose_sign_in={watch}")],
    "signed out": [("cookie", "truepose_sign_in={signed_out}")],
    "cookie of one who was removed": [("cookie", "truepose_sign_in={cookie_of_removed}")],
    "empty cookie": [("cookie", "truepose_sign_in=")],
    "two cookies": [("cookie", "truepose_sign_in={cookie}; truepose_sign_in={cookie}")],
    "bad and good cookie": [("cookie", "truepose_sign_in=x; truepose_sign_in={cookie}")],
    "cookies in two lines": [
        ("cookie", "truepose_sign_in={cookie}"),
        ("cookie", "truepose_sign_in={cookie}"),
    ],
    "quoted cookie": [("cookie", 'truepose_sign_in="{cookie}"')],
    "cookie of another name": [("cookie", "Truepose_sign_in={cookie}")],
    "secure cookie without TLS": [("cookie", "__Host-truepose_sign_in={cookie}")],
    "method in header": [("x-http-method-override", "GET")],
    "address in header": [("x-original-url", "/health"), ("x-rewrite-url", "/health")],
}
PATHS = [
    "//api/v1/sessions",
    "/api//v1/sessions",
    "/api/v1/sessions/",
    "/api/v1/sessions.",
    "/api/v1/sessions/.",
    "/api/v1/./sessions",
    "/health/../api/v1/sessions",
    "/static/../api/v1/sessions",
    "/static/%2e%2e/api/v1/sessions",
    "/api/v1/sessions;/health",
    "/api/v1/sessions?/health",
    "/api/v1/sessions#/health",
    "/api/v1/sessions\x00/health",
    "/API/V1/SESSIONS",
    "/api/v1/sessions\n",
    "/sign-in/../api/v1/people",
    "/watch/../api/v1/people",
    "/api/v1/sign-ins/../people",
    "/%61pi/v1/sessions",
    "\\api\\v1\\sessions",
]
PLACES = [
    ("GET", "/api/v1/sessions"),
    ("POST", "/api/v1/sessions/1/commands"),
    ("GET", "/api/v1/people"),
    ("POST", "/api/v1/tokens"),
    ("GET", "/api/v1/events"),
    ("GET", "/docs"),
    ("GET", "/openapi.json"),
]


def filled(headers, secrets):
    good = secrets["good"]
    values = secrets | {
        "good_swapped": good.swapcase(),
        "good_shorter": good[:-1],
        "good_hash": "0" * 64,
    }
    return [(name, value.format(**values) if "{" in value else value) for name, value in headers]


@pytest.mark.parametrize("way", HEADERS)
async def test_it_lets_nobody_in(house, secrets, way):
    for method, path in PLACES:
        headers = [HOST, ORIGIN, *filled(HEADERS[way], secrets)]
        answer = await asked(house.app, method, path, headers, b"{}")
        to_sign_in = answer.status == 303 and answer.headers["location"].startswith("/sign-in")
        assert answer.status in KEPT_OUT or to_sign_in, (method, path)


@pytest.mark.parametrize("path", PATHS)
async def test_no_spelling_of_a_path_leads_around(house, path):
    for method in ("GET", "POST", "DELETE"):
        answer = await asked(house.app, method, path, [HOST, ORIGIN], b"{}")
        assert answer.status in KEPT_OUT, (method, path)


async def test_what_is_good_lets_in(house, secrets):
    """Else the list above would prove nothing."""
    for name, value in (
        ("authorization", f"Bearer {secrets['good']}"),
        ("authorization", f"bearer  {secrets['good']}"),
        ("cookie", f"language=fr; truepose_sign_in={secrets['cookie']}"),
    ):
        answer = await asked(house.app, "GET", "/api/v1/people", [HOST, (name, value)])
        assert (answer.status, "metrologist" in answer.detail) == (403, True)  # known, and may not


async def test_a_cookie_changes_nothing_for_a_page_of_others(house, secrets):
    cookie = ("cookie", f"truepose_sign_in={secrets['cookie']}")
    for headers in (
        [],
        [("origin", "http://evil.example")],
        [("origin", "null")],
        [("sec-fetch-site", "cross-site")],
        [("sec-fetch-site", "same-site"), ("origin", "http://localhost:9000")],
        [("referer", "http://evil.example/")],
    ):
        answer = await asked(
            house.app, "POST", "/api/v1/sessions/1/commands", [HOST, cookie, *headers], b"{}"
        )
        assert answer.status == 403, headers
