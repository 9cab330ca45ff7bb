"""`python -m truepose_simulators.recording.on_request`: many campaigns from one process.

Each line of standard input is a JSON list of arguments as `python -m truepose_simulators.recording` takes
them; each is answered by a line with the exit status that the command would have. The end of input ends it.
"""

import json
import sys
from collections.abc import Callable, Sequence
from typing import TextIO

from truepose_simulators.recording.__main__ import EXIT_UNUSABLE_INPUT, fail, main


def serve(requests: TextIO, answers: TextIO, record: Callable[[Sequence[str]], int]) -> None:
    """Answer requests until there are no more."""
    for line in requests:
        answers.write(f"{_status(line, record)}\n")
        answers.flush()


def _status(line: str, record: Callable[[Sequence[str]], int]) -> int:
    try:
        arguments = json.loads(line)
    except ValueError as error:
        return fail(f"a request is a JSON list of arguments, not {line.strip()!r}: {error}")
    if not isinstance(arguments, list) or not all(isinstance(one, str) for one in arguments):
        return fail(f"a request is a JSON list of strings, not {line.strip()!r}")
    try:
        return record(arguments)
    except SystemExit as refusal:  # what argparse does after its own sentence
        return refusal.code if isinstance(refusal.code, int) else EXIT_UNUSABLE_INPUT


if __name__ == "__main__":
    serve(sys.stdin, sys.stdout, main)
