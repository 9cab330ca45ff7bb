"""Files as browsers are sent them: asked for again each time, sent again only where they have changed.

So pages never mix versions, and a tablet that opens its tenth page fetches no script.
"""

import hashlib
from collections.abc import Mapping
from typing import Final

from fastapi import Request
from fastapi.responses import Response

_COMPRESSED: Final = ("text/", "application/json")  # on their way: the same tag stands for both forms


def sent(
    request: Request, body: bytes, media_type: str, headers: Mapping[str, str] | None = None
) -> Response:
    """Return a file, or that the browser which asks has it already."""
    weak = "W/" if media_type.startswith(_COMPRESSED) else ""
    tag = f'"{hashlib.sha256(body).hexdigest()}"'
    head = {"Cache-Control": "private, no-cache", "ETag": f"{weak}{tag}", **(headers or {})}
    if tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=head)
    return Response(body, media_type=media_type, headers=head)
