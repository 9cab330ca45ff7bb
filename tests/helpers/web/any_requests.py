"""Requests drawn from an OpenAPI document, as it means them and as nobody means them, byte by byte.

There are halves of characters, bytes that are no text, bodies of the right form and of none. A request goes
over a socket as it is drawn, since a client would put much of it right.
"""

import json
import socket
import string
from dataclasses import dataclass
from urllib.parse import quote, quote_from_bytes

METHODS = ("get", "post", "put", "delete", "patch")
STREAM = {"stop_after_s": "0.05"}  # of what does not end by itself
ODD_TEXTS = [
    "\ud83d", "a\udc00b", "\udfff\ud800", "\x00", "\u202e", "", " ", "'", "=1+1", "%", "../..", "\r\nX: y",
    "a" * 5000, "\U0001f916", "cafe\u0301", "\ufffe", "NaN", "-1", "1e999", "null", "<script>", "{}", "[]",
]  # fmt: skip
ODD_NUMBERS = [0, -1, 1, 2, 3.5, 1e308, -1e-320, 2**31, 2**63, 10**40, float("nan"), float("inf")]
ODD_BYTES = [b"\xff\xfe", b"\xed\xa0\xbd", b"\x00", b"PK\x03\x04", b"{", b'"\xed\xa0\xbd"', b"[" * 3000, b""]
LEFT_ALONE = {"change_role", "remove_person", "revoke_token"}  # of whoever asks: they go on asking
ENDS_ASKING = {"sign_out"}
SPARE = range(200, 240)


@dataclass(frozen=True)
class Asked:
    """A request, and what came of it."""

    name: str
    raw: bytes


@dataclass(frozen=True)
class Answered:
    """What a service said; None: the connection ended without an answer."""

    status: int | None
    body: bytes


class Drawing:
    """Draws requests of a document."""

    def __init__(self, document, draw):
        self._schemas = document["components"]["schemas"]
        self._operations = [
            (path, method, operation)
            for path, methods in sorted(document["paths"].items())
            for method, operation in sorted(methods.items())
            if method in METHODS and operation["operationId"] not in ENDS_ASKING
        ]
        self._draw = draw

    def request(self, headers):
        """Return a request of whoever sends these headers."""
        path, method, operation = self._draw.choice(self._operations)
        name = operation["operationId"]
        target, more = self._target(name, path, operation.get("parameters", []))
        media_type, body = self._body(operation)
        sent = [b"host: localhost", b"origin: http://localhost", b"connection: close", *headers, *more]
        if body is not None:
            sent += [b"content-type: " + media_type.encode(), b"content-length: %d" % len(body)]
        head = method.upper().encode() + b" " + target + b" HTTP/1.1"
        return Asked(name, b"\r\n".join([head, *sent, b"", body or b""]))

    def _target(self, name, path, parameters):
        queries, headers = [], []
        for one in parameters:
            value = self._parameter(name, one)
            if one["in"] == "path":
                path = path.replace(f"{{{one['name']}}}", value)
            elif one["name"] in STREAM:
                queries.append(f"{one['name']}={STREAM[one['name']]}")
            elif one["in"] == "query" and self._perhaps(0.5):
                queries.append(f"{quote(one['name'])}={value}")
            elif one["in"] == "header" and (one.get("required") or self._perhaps(0.3)):
                headers.append(f"{one['name']}: {value}".encode("latin-1"))
        if self._perhaps(0.05):
            queries.append(f"{quote_from_bytes(self._draw.choice(ODD_BYTES))}=%ed%a0%bd")
        return (path + ("?" + "&".join(queries) if queries else "")).encode("latin-1"), headers

    def _parameter(self, name, one):
        """Return the text of a parameter as it stands in an address or a header."""
        if one["in"] == "path" and name in LEFT_ALONE:
            return str(self._draw.choice(SPARE))
        if self._perhaps(0.3):
            odd = self._draw.choice(ODD_BYTES) + self._odd_text().encode("utf-8", "surrogatepass")
            return quote_from_bytes(odd)[:2000]
        if one["in"] == "path" and self._perhaps(0.7):
            return str(self._draw.randint(1, 3))
        return quote(str(self._value(one.get("schema", {}), 0)).encode("utf-8", "surrogatepass"))[:2000]

    def _body(self, operation):
        """Return type and bytes of a body; None where none is sent."""
        content = operation.get("requestBody", {}).get("content", {})
        if not content:
            return ("application/json", self._json({})) if self._perhaps(0.1) else ("", None)
        media_type = self._draw.choice(sorted(content))
        if self._perhaps(0.1):
            media_type = self._draw.choice(["application/json", "text/csv", "application/zip", "x"])
        if media_type != "application/json" or self._perhaps(0.05):
            return media_type, self._bytes(media_type)
        schema = next(iter(content.values())).get("schema", {})
        return media_type, self._json(self._value(schema, 0) if self._perhaps(0.8) else self._anything(0))

    def _json(self, value):
        text = json.dumps(value)
        return (text.replace("NaN", "1") if self._perhaps(0.9) else text).encode()

    def _bytes(self, media_type):
        noise = self._draw.choice(ODD_BYTES) + self._draw.randbytes(self._draw.randint(0, 200))
        if not media_type.startswith("multipart"):
            return noise
        name = self._odd_text().encode("utf-8", "surrogatepass").replace(b"\r\n", b"")
        head = b'--x\r\ncontent-disposition: form-data; name="file"; filename="' + name + b'"\r\n\r\n'
        return head + noise + b"\r\n--x--\r\n"

    def _value(self, schema, depth):
        """Return a value that a schema asks for, or now and then another one."""
        if self._perhaps(0.06) or depth > 8:
            return self._anything(depth)
        if "$ref" in schema:
            return self._value(self._schemas[schema["$ref"].rpartition("/")[2]], depth + 1)
        for key in ("anyOf", "oneOf", "allOf"):
            if key in schema:
                return self._value(self._draw.choice(schema[key]), depth + 1)
        if "const" in schema or "enum" in schema:
            return self._draw.choice(schema.get("enum", [schema.get("const")]))
        if schema.get("examples") and self._perhaps(0.5):
            return self._draw.choice(schema["examples"])
        return self._of_type(schema, depth)

    def _of_type(self, schema, depth):
        match schema.get("type"):
            case "object":
                return self._object(schema, depth)
            case "array":
                count = self._draw.randint(schema.get("minItems", 0), min(schema.get("maxItems", 4), 6))
                return [self._value(schema.get("items", {}), depth + 1) for _ in range(count)]
            case "integer" | "number":
                if self._perhaps(0.2):
                    return self._draw.choice(ODD_NUMBERS)
                greatest = int(min(schema.get("maximum", 9), 1e6))
                return self._draw.randint(int(schema.get("minimum", 0)), greatest)
            case "string":
                return self._odd_text() if self._perhaps(0.3) else self._text()
            case "boolean":
                return self._perhaps(0.5)
            case "null":
                return None
        return self._anything(depth)

    def _object(self, schema, depth):
        needed = set(schema.get("required", ()))
        said = {
            name: self._value(part, depth + 1)
            for name, part in schema.get("properties", {}).items()
            if (name in needed and not self._perhaps(0.03)) or self._perhaps(0.4)
        }
        return said | ({self._odd_text(): 1} if self._perhaps(0.04) else {})

    def _anything(self, depth):
        if depth < 4 and self._perhaps(0.3):
            return [self._anything(depth + 1) for _ in range(self._draw.randint(0, 3))]
        if depth < 4 and self._perhaps(0.3):
            return {self._odd_text(): self._anything(depth + 1) for _ in range(self._draw.randint(0, 3))}
        return self._draw.choice([None, True, self._odd_text(), self._text(), *ODD_NUMBERS])

    def _odd_text(self):
        return self._draw.choice(ODD_TEXTS)

    def _text(self):
        return "".join(self._draw.choices(string.ascii_letters + " -_.", k=self._draw.randint(1, 12)))

    def _perhaps(self, share):
        return self._draw.random() < share


def answer_of(port, raw, patience_s=300.0):
    """Send bytes to a service of this computer and return its answer."""
    received = b""
    try:
        with socket.create_connection(("127.0.0.1", port), patience_s) as link:
            link.sendall(raw)
            while part := link.recv(65536):
                received += part
    except OSError:
        return Answered(None, received)
    head, _, body = received.partition(b"\r\n\r\n")
    words = head.split(b" ", 2)
    return Answered(int(words[1]) if words[0].startswith(b"HTTP/1.") else None, body)
