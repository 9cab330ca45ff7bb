"""`python -m truepose_simulators.recording SCENARIO --out FOLDER`: a campaign folder, drawn or replayed."""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ReplayError, SimulatorError
from truepose_simulators.recording.ballbars.campaign import (
    BallbarRecordingRequest,
    record_ballbar,
    write_ballbar_campaign,
)
from truepose_simulators.recording.ballbars.plan import read_plan
from truepose_simulators.recording.campaign import record
from truepose_simulators.recording.closed_loop_campaign import LoopRecordingRequest, record_loop, write_loop
from truepose_simulators.recording.closed_loops import LOOPS
from truepose_simulators.recording.files import write_campaign
from truepose_simulators.recording.plan import APPROACHES, RecordingRequest
from truepose_simulators.recording.replay import replay, write_replay
from truepose_simulators.scenarios.file import load_scenario, shipped_scenarios
from truepose_simulators.scenarios.model_file import load_model
from truepose_simulators.scenarios.scenario import Scenario

EXIT_UNUSABLE_INPUT = 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Record one campaign; returns the exit status."""
    options = _parse(arguments)
    try:
        _write(options, load_scenario(options.scenario), _wishes(options))
    except SimulatorError as error:
        return fail(str(error))
    except OSError as error:
        return fail(f"{options.out} cannot be written: {error.strerror}")
    return 0


def _wishes(options: argparse.Namespace) -> RecordingRequest:
    """Return what was asked of the tracker campaign; what was not is usual, beside a ballbar or alone."""
    usual = RecordingRequest() if options.ballbar is None else BallbarRecordingRequest().tracker
    asked = {name: getattr(options, name) for name in RecordingRequest.__dataclass_fields__}
    return replace(usual, **{name: value for name, value in asked.items() if value is not None})


def _loop_wishes(options: argparse.Namespace) -> LoopRecordingRequest:
    asked = {name: getattr(options, name) for name in ("configurations", "validation", "approach")}
    return LoopRecordingRequest(
        options.loop, **{name: value for name, value in asked.items() if value is not None}
    )


def _write(options: argparse.Namespace, scenario: Scenario, wishes: RecordingRequest) -> None:
    model = None if options.model is None else load_model(options.model)
    scenario = scenario.quiet() if options.quiet else scenario
    if options.loop is not None:
        write_loop(record_loop(scenario, options.seed, _loop_wishes(options)), options.out)
        return
    if options.ballbar is not None:
        ballbar = BallbarRecordingRequest(options.aimed, options.aim_error, options.approach, wishes)
        plan = read_plan(options.ballbar)
        write_ballbar_campaign(record_ballbar(scenario, options.seed, plan, ballbar, model), options.out)
        return
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
    parser = argparse.ArgumentParser(
        prog="python -m truepose_simulators.recording",
        description="Record a tracker campaign of a simulated cell and write it as a folder.",
        epilog="example: python -m truepose_simulators.recording irb120-everyday --seed 3 --out everyday-3",
    )
    add = parser.add_argument
    add("scenario", help=f"a scenario file or one of {', '.join(shipped_scenarios())}")
    add("--out", type=Path, required=True, help="folder to write into")
    add("--seed", type=int, default=0, help="random seed, 0 or more: which cell of that kind (default: 0)")
    for name, what in (
        ("configurations", "calibration configurations"),
        ("validation", "validation configurations"),
        ("revisits", "repeat measurements"),
        ("attachments", "tool mountings"),
        ("reference-every", "configurations between readings of the fixed nests, 0 for none"),
    ):
        alone, beside = (
            getattr(usual, name.replace("-", "_"))
            for usual in (RecordingRequest(), BallbarRecordingRequest().tracker)
        )
        default = f"{alone}" if alone == beside else f"{alone}, beside --ballbar {beside}"
        add(f"--{name}", type=int, help=f"{what} (default: {default})")
    add("--approach", choices=APPROACHES, default=RecordingRequest().approach, help="default: %(default)s")
    add("--quiet", action="store_true", help="without the drift and warm-up of an everyday robot")
    add("--ballbar", type=Path, metavar="PLAN", help="also record a ballbar campaign from this plan (JSON)")
    add("--aimed", action="store_true", help="ballbar: joints corrected as by a pre-calibration")
    add(
        "--aim-error",
        type=float,
        default=BallbarRecordingRequest().aim_error_mm,
        help="length error left by that correction, mm (default: %(default)s)",
    )
    add("--loop", choices=LOOPS, help="record a closed loop of this kind instead")
    add("--model", type=Path, help="identified model (JSON) that replaces the robot")
    add("--replay", type=Path, help="measured campaign folder to replay, with --model")
    options = parser.parse_args(arguments)
    if options.replay is not None and options.model is None:
        parser.error("argument --replay: also give the model of that robot, with --model")
    if options.replay is not None and options.ballbar is not None:
        parser.error("argument --ballbar: cannot be combined with --replay")
    if options.loop is not None and (options.ballbar is not None or options.model is not None):
        parser.error("argument --loop: cannot be combined with --ballbar or --model")
    if options.seed < 0:
        parser.error(f"argument --seed: {options.seed} is negative")
    return options


def fail(sentence: str) -> int:
    """Say what cannot be used; returns the exit status."""
    sys.stderr.write(f"{sentence}\n")
    return EXIT_UNUSABLE_INPUT


if __name__ == "__main__":
    sys.exit(main())
