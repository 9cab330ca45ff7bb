"""`python -m simulators.recording SCENARIO --out FOLDER`: writes a campaign folder."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from simulators.errors import SimulatorError
from simulators.recording.campaign import record
from simulators.recording.files import write_campaign
from simulators.recording.plan import APPROACHES, Wishes
from simulators.scenario_file import load_scenario, shipped_scenarios

_EXIT_UNUSABLE_INPUT = 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Record one campaign; returns the exit status."""
    options = _parse(arguments)
    try:
        wishes = Wishes(
            configurations=options.configurations,
            validation=options.validation,
            revisits=options.revisits,
            approach=options.approach,
            attachments=options.attachments,
            reference_every=options.reference_every,
        )
        write_campaign(record(load_scenario(options.scenario), options.seed, wishes), options.out)
    except SimulatorError as error:
        return _fail(str(error))
    except OSError as error:
        return _fail(f"{options.out} cannot be written: {error.strerror}")
    return 0


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    usual = Wishes()
    parser = argparse.ArgumentParser(
        prog="python -m simulators.recording",
        description="Record a tracker campaign of a simulated cell and write it as a folder.",
        epilog="example: python -m simulators.recording irb120-everyday --seed 3 --out everyday-3",
    )
    add = parser.add_argument
    add("scenario", help=f"a scenario file or one of {', '.join(shipped_scenarios())}")
    add("--out", type=Path, required=True, help="folder to write into")
    add("--seed", type=int, default=0, help="which cell of that kind, 0 or more (default: 0)")
    add("--configurations", type=int, default=usual.configurations, help="default: %(default)s")
    add("--validation", type=int, default=usual.validation, help="further ones (default: %(default)s)")
    add("--revisits", type=int, default=usual.revisits, help="visited again (default: %(default)s)")
    add("--approach", choices=APPROACHES, default=usual.approach, help="default: %(default)s")
    add("--attachments", type=int, default=usual.attachments, help="mountings (default: %(default)s)")
    add(
        "--reference-every",
        type=int,
        default=usual.reference_every,
        help="stops between readings of the fixed nests, 0 for none (default: %(default)s)",
    )
    options = parser.parse_args(arguments)
    if options.seed < 0:
        parser.error(f"argument --seed: {options.seed} is negative")
    return options


def _fail(sentence: str) -> int:
    sys.stderr.write(f"{sentence}\n")
    return _EXIT_UNUSABLE_INPUT


if __name__ == "__main__":
    sys.exit(main())
