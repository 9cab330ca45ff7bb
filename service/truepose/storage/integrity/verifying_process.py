"""The process that looks through a database (`python -m` this module): its URL in, JSON lines out.

The URL may hold a password, so it is read and is no argument, which everybody on the machine can see.
"""

import json
import os
import sys
from typing import Any, Final

from truepose.storage.integrity.verification import verify_at

_LOWEST_PRIORITY: Final = 19


def main() -> None:
    """Look through the database named and tell how far that is, then what was found."""
    if hasattr(os, "nice"):
        os.nice(_LOWEST_PRIORITY)
    verdict = verify_at(sys.stdin.readline().strip(), lambda share: _tell(share=round(share, 3)))
    _tell(share=1.0, findings=verdict.findings, records=verdict.records)


def _tell(**what: Any) -> None:
    sys.stdout.write(json.dumps(what) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
