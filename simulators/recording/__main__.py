"""`python -m simulators.recording SCENARIO --out FOLDER`: writes a campaign folder, drawn or replayed."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from simulators.cell import Cell
from simulators.clock import CellClock
from simulators.errors import ReplayError, SimulatorError
from simulators.model_file import load_model
from simulators.recording.campaign import record
from simulators.recording.files import write_campaign
from simulators.recording.plan import APPROACHES, Wishes
from simulators.recording.replay import replay, write_replay
from simulators.scenario import Scenario
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
        _write(options, load_scenario(options.scenario), wishes)
    except SimulatorError as error:
        return _fail(str(error))
    except OSError as error:
        return _fail(f"{options.out} cannot be written: {error.strerror}")
    return 0


def _write(options: argparse.Namespace, scenario: Scenario, wishes: Wishes) -> None:
    model = None if options.model is None else load_model(options.model)
    if model is None or options.replay is None:
        write_campaign(record(scenario, options.seed, wishes, model), options.out)
        return
    if options.out.resolve() == options.replay.resolve():
        raise ReplayError(f"--out {options.out} is the measured campaign itself; choose another folder")
    replayed = replay(Cell(scenario, options.seed, CellClock(0), model), model, options.replay)
    write_replay(replayed, options.out)
    for remark in replayed.remarks:
        sys.stderr.write(f"{remark}\n")


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
    add("--model", type=Path, help="identified model (JSON) that stands in the place of the robot")
    add("--replay", type=Path, help="measured campaign folder whose stops are made again, with --model")
    options = parser.parse_args(arguments)
    if options.replay is not None and options.model is None:
        parser.error("argument --replay: name the model of that robot too, with --model")
    if options.seed < 0:
        parser.error(f"argument --seed: {options.seed} is negative")
    return options


def _fail(sentence: str) -> int:
    sys.stderr.write(f"{sentence}\n")
    return _EXIT_UNUSABLE_INPUT


if __name__ == "__main__":
    sys.exit(main())
