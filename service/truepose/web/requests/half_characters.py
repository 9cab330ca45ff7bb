r"""Halves of characters in JSON: `"\ud83d"` alone is no text, and neither kept nor sent on.

JSON allows it, Python reads it, and the first that encodes it fails: it is refused before anything does.
"""

import json
import re
from typing import Final

_SUSPECT: Final = re.compile(
    rb"\\u[dD][89a-fA-F]|\xed[\xa0-\xbf]|\x00"
)  # a zero: of UTF-16, which JSON may be


def has_half_character(body: bytes) -> bool:
    """Whether a body of JSON holds half a character; what is no JSON is told by whoever reads it."""
    if _SUSPECT.search(body) is None:
        return False
    try:
        json.dumps(json.loads(body), ensure_ascii=False).encode()
    except UnicodeEncodeError:
        return True
    except (ValueError, RecursionError):
        return False
    return False
