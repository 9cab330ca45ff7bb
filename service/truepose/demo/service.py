"""The service on a simulated cell as the child of a run.

Started as `python -m truepose.demo.service SCENARIO SEED DATABASE_URL`.

What `truepose serve` runs, with two differences: waiting costs no wall time, and it ends when its standard
input ends, so that a run which is killed leaves no service behind, and no cell.
"""

import os
import signal
import sys
import threading

from truepose.processes import interrupt_this_process
from truepose.start import begin_lightly, end_lightly, speak_unicode

_CHUNK_BYTES = 4096


def main(scenario: str, seed: str, database_url: str) -> int:
    """Serve on any free port of loopback until interrupted; returns the exit status."""
    begin_lightly()
    speak_unicode()
    from truepose.app import serve
    from truepose.settings import Settings

    # A run in the background of a shell hands down that SIGINT is ignored, and then nothing would end us.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Thread(target=_end_with_the_run, daemon=True).start()
    settings = Settings(
        database_url=database_url,
        port=0,
        simulated_pace=0,
        simulated_scenario=scenario,
        simulated_seed=int(seed),
    )
    try:
        return serve(settings)
    finally:
        end_lightly()


def _end_with_the_run() -> None:
    # Not sys.stdin: its buffer is locked while we read, and the interpreter wants that lock when it ends.
    while os.read(0, _CHUNK_BYTES):
        pass
    interrupt_this_process()


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
