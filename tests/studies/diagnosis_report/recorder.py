"""A child process that records campaigns of simulated cells: started once, asked many times."""

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from typing import IO

from tests.studies.diagnosis_report.errors import RecorderFailedError


class Recorder:
    """Asks the simulators' recorder for one campaign after the other."""

    def __init__(self, requests: IO[str], answers: IO[str]) -> None:
        self._requests = requests
        self._answers = answers

    def record(self, *arguments: str) -> None:
        """Record a campaign, with the arguments of `python -m truepose_simulators.recording`.

        Raises
        ------
        RecorderFailedError
            The recorder refuses the request or has ended; its own sentence is on standard error.
        """
        try:
            self._requests.write(json.dumps(arguments) + "\n")
            self._requests.flush()
            answer = self._answers.readline()
        except OSError as error:
            raise RecorderFailedError(f"The recorder of campaigns does not answer ({error}).") from error
        if answer.strip() != "0":
            request = " ".join(arguments)
            raise RecorderFailedError(f"The recorder of campaigns refused '{request}'; see above.")


@contextlib.contextmanager
def running_recorder() -> Iterator[Recorder]:
    """Start the recorder and end it with the context."""
    process = subprocess.Popen(
        [sys.executable, "-m", "truepose_simulators.recording.on_request"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    with process:  # closes its standard input, which ends it, and waits
        if process.stdin is None or process.stdout is None:
            raise RecorderFailedError("The recorder of campaigns has no standard streams.")
        yield Recorder(process.stdin, process.stdout)
