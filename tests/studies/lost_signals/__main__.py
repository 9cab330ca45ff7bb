"""How often the arm moves with the ballbar attached while the ballbar's signals come and go.

    python -m tests.studies.lost_signals --sessions 300

Sessions in memory, on the devices of the unit tests: the ballbar is switched off, its cable pulled, its line
silent, its count frozen, its out-of-range flag wrong, its serial number another, the service restarted, each
at random moments, with a person who confirms whatever is asked. Whoever moves the arm in these sessions knows
where the ballbar is.
"""

import asyncio
import json
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict

from tests.studies.lost_signals.session import Seen, session
from tests.studies.running import study_options


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; exit status 1 where the arm moved with the ballbar attached, or never."""
    given = study_options(__doc__, arguments, sessions=300, seed=(0, "of the first session"), processes=2)
    seeds = range(given.seed, given.seed + given.sessions)
    whole = Seen()
    if given.processes == 1:
        for seed in seeds:
            whole.add(seen_in(seed))
    else:
        with ProcessPoolExecutor(given.processes) as pool:
            for seen in pool.map(seen_in, seeds):
                whole.add(seen)
    document = {"sessions": given.sessions, **asdict(whole), "troubles": dict(whole.troubles)}
    sys.stdout.write(json.dumps(document, indent=1) + "\n")
    return 0 if whole.motions and not whole.motions_attached else 1


def seen_in(seed: int) -> Seen:
    """Return what was seen of one session."""
    return asyncio.run(session(seed))


if __name__ == "__main__":
    sys.exit(main())
