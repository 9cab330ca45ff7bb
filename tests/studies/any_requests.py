"""Asks a service anything, as every role and as nobody: python -m tests.studies.any_requests --requests 5000.

Requests are drawn from the document, with halves of characters, bytes that are no text, and bodies of no
form. Exit status 1: some ended in 5xx, or in a connection that was reset.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from tests.helpers.web.strangers import outcome_of


def main():
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--requests", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        outcome = outcome_of(Path(folder), asked.requests, asked.seed)
    for status, count in sorted(outcome.statuses.items(), key=str):
        sys.stdout.write(f"{status}: {count}\n")
    for role, request, answer in outcome.failed:
        sys.stdout.write(f"{role}: {request.name} -> {answer.status}\n  {request.raw!r}\n  {answer.body!r}\n")
    sys.stdout.write(f"{len(outcome.failed)} of {asked.requests} ended in 5xx or in a reset\n")
    sys.exit(bool(outcome.failed))


if __name__ == "__main__":
    main()
