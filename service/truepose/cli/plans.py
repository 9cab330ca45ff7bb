"""The command that plans a session and says what it promises. Heavy imports wait until it runs."""

import dataclasses
import functools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.files import Json, Language, Workers, read_measured, require_folders, writing
from truepose.cli.output import print_json, print_lines, print_tables, progress_bar, remark
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import ENGLISH, catalogue, english

if TYPE_CHECKING:
    from truepose.analysis.best_plan import MakePlan
    from truepose.domain.cell import KeepOuts
    from truepose.domain.robot import Nest, Robot
    from truepose.messages.message import Message
    from truepose.planning.contacts.loop_configurations import LoopPlanRequest
    from truepose.planning.prediction.plan import PromisedPlan, WorkVolume
    from truepose.planning.prediction.robots_and_cells import Subject

_USUAL_READING_MM = 0.001  # of a touch probe or a linear gauge


def plan_command(
    subject: Annotated[
        str, typer.Argument(help="Shipped robot, robot or cell file (TOML), scenario, or campaign folder.")
    ],
    n: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=1000,
            help="Number of configurations to measure (default: the knee of the accuracy curve).",
        ),
    ] = None,
    volume: Annotated[
        Path | None, typer.Option(help="Where accuracy counts: a box, joint ranges, or both (TOML or JSON).")
    ] = None,
    keep_out: Annotated[
        Path | None,
        typer.Option(
            help="Volumes that the arm must not enter: boxes, cylinders, half spaces (TOML or JSON)."
        ),
    ] = None,
    one_sided: Annotated[
        bool,
        typer.Option("--one-sided", help="Keep gravity-loaded gears loaded from one side (needs masses)."),
    ] = False,
    ballbar: Annotated[
        bool, typer.Option("--ballbar", help="Measure with a ballbar instead of a tracker.")
    ] = False,
    targets: Annotated[
        Path | None,
        typer.Option(
            help="Measure a closed loop with these targets and their positions (CSV) instead of a tracker."
        ),
    ] = None,
    distances: Annotated[
        Path | None, typer.Option(help="Certified distances of the targets of a closed loop (CSV).")
    ] = None,
    nests: Annotated[
        str, typer.Option(help="Tool nests that a closed loop uses, separated by commas (default: all).")
    ] = "",
    reading_mm: Annotated[
        float | None,
        typer.Option(help="Standard uncertainty of a reading per axis (default: a typical tracker)."),
    ] = None,
    discrepancy_mm: Annotated[
        float | None,
        typer.Option(help="Error per axis that no parameter describes (default: as known for the robot)."),
    ] = None,
    limit_mm: Annotated[
        float | None, typer.Option(help="Predict whether the largest error stays within this limit.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same plan.")] = 0,
    tries: Annotated[
        int,
        typer.Option(
            min=1, max=1000, help="Number of seeds to plan with; the plan with the largest O1 is kept."
        ),
    ] = 1,
    workers: Workers = None,
    out: Annotated[Path | None, typer.Option(help="Write the configurations here (CSV).")] = None,
    report: Annotated[
        Path | None, typer.Option(help="Write a checklist for the cell here: .html, or .pdf to print.")
    ] = None,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Choose configurations to measure, and predict the accuracy before anything moves.

    For a campaign, the prediction includes its readings. Status 1: the plan cannot determine a parameter.

    Example: truepose plan abb-irb-120 --n 40 --out plan.csv
    """
    require_folders(out, report)
    reading_mm, tried = _size(reading_mm, "--reading-mm"), _Tries(seed, tries, workers)
    asked = _PlanRequest(subject, n, volume, keep_out, reading_mm, tried, one_sided)
    lacking_mm = _size(discrepancy_mm, "--discrepancy-mm")
    loop = _loop(targets, distances, nests, ballbar=ballbar)
    if loop is not None:
        made = _for_loop(asked, loop, lacking_mm)
    else:
        made = _for_ballbar(asked, lacking_mm) if ballbar else _for_tracker(asked, lacking_mm)
    made = dataclasses.replace(made, limit_mm=_limit(limit_mm))
    if out is not None:
        _write(out, made.plan)
    if report is not None:
        _write_checklist(report, made, Path(subject).stem, language)
    _print(made, language, as_json=json)
    return 1 if made.plan.left_open else 0


def _size(size_mm: float | None, option: str) -> float | None:
    if size_mm is not None and not 0.0 <= size_mm < math.inf:
        raise ConfigurationError(f"{option} {size_mm:g}: give a standard deviation in mm, 0 or more.")
    return size_mm


def _limit(limit_mm: float | None) -> float | None:
    if limit_mm is not None and not 0.0 < limit_mm < math.inf:
        raise ConfigurationError(f"--limit-mm {limit_mm:g}: give a limit above 0 mm.")
    return limit_mm


@dataclass(frozen=True, slots=True)
class _Tries:
    """How many plans are made, from which seed on, and by whom."""

    seed: int
    count: int
    where: str | None

    def best(self, n: int | None, planned: "MakePlan") -> "PromisedPlan":
        """Return the plan, or the best of several."""
        if self.count == 1:
            return planned(n=n, seed=self.seed)
        from truepose.analysis.best_plan import best_plan
        from truepose.analysis.parallel.local_pool import workers

        with workers(self.where, self.count) as cluster, progress_bar() as told:
            plan, seed = best_plan(cluster, planned, n, self.seed, self.count, told)
        remark([f"The plan with seed {seed} has the largest O1 of {self.count} plans."])
        return plan


@dataclass(frozen=True, slots=True)
class _PlanRequest:
    """What the command line asks for."""

    subject: str
    n: int | None
    volume: Path | None
    keep_out: Path | None
    reading_mm: float | None
    tries: _Tries
    one_sided: bool

    @property
    def is_campaign(self) -> bool:
        """Whether the subject is a folder, or the zip of one."""
        path = Path(self.subject)
        return path.is_dir() or path.suffix.lower() == ".zip"

    def work_volume(self, robot: "Robot") -> "WorkVolume | None":
        """Return the volume that a file describes."""
        from truepose.exchange.cells.volumes import read_volume

        return None if self.volume is None else read_volume(self.volume, robot.n_joints)

    def keep_outs(self) -> "KeepOuts":
        """Return the keep-out volumes of a file, none without one."""
        from truepose.domain.cell import KeepOuts
        from truepose.exchange.cells.volumes import read_keep_out_file

        return KeepOuts() if self.keep_out is None else read_keep_out_file(self.keep_out)


@dataclass(frozen=True, slots=True)
class _Loop:
    """The files of a closed loop."""

    targets: Path
    distances: Path | None
    nests: tuple[int, ...]  # none: all of the tool


def _loop(targets: Path | None, distances: Path | None, nests: str, *, ballbar: bool) -> _Loop | None:
    if targets is None:
        if distances is not None or nests:
            raise ConfigurationError(
                "--distances and --nests apply to closed loops only: give --targets as well."
            )
        return None
    if ballbar:
        raise ConfigurationError("--targets and --ballbar cannot be combined; give only one of them.")
    numbers = nests.replace(" ", "").split(",") if nests else []
    if not all(number.isdigit() for number in numbers):
        raise ConfigurationError(f"--nests {nests}: give numbers of tool nests with commas, such as 1,2,3.")
    return _Loop(targets, distances, tuple(map(int, numbers)))


@dataclass(frozen=True, slots=True)
class _RobotPlan:
    """A plan and what it is of."""

    robot: "Robot"
    plan: "PromisedPlan"
    minutes: float
    nominal_mm: float | None = None  # on what was measured before
    limit_mm: float | None = None  # of the largest error

    @property
    def outcome(self) -> "Message":
        """The sentence that everything about it begins with."""
        from truepose.planning.prediction.outcome import plan_outcome

        return plan_outcome(self.plan, self.nominal_mm, self.limit_mm)


def _for_tracker(asked: _PlanRequest, discrepancy_mm: float | None) -> _RobotPlan:
    from truepose.planning.prediction.tracker import promised_session, session_plan
    from truepose.sessions.tracker.dry_run import minutes_of

    subject = _subject(asked, discrepancy_mm)
    space, knowns = subject.space, subject.knowns
    volume = asked.work_volume(space.robot)
    if asked.one_sided and not space.robot.masses:
        raise ConfigurationError(f"--one-sided needs masses, which are not known for {space.robot.name}.")
    planned = functools.partial(
        promised_session,
        space,
        knowns=knowns,
        volume=volume,
        measured=subject.measured,
        one_sided=asked.one_sided,
    )
    plan = asked.tries.best(asked.n, planned)
    minutes = minutes_of(session_plan(plan), space, len(knowns.fixed_nests))
    return _RobotPlan(space.robot, plan, minutes, subject.nominal_mm)


def _subject(asked: _PlanRequest, discrepancy_mm: float | None) -> "Subject":
    from truepose.exchange.cells.file import cell_given
    from truepose.planning.prediction.robots_and_cells import of_cell

    subject = _of_campaign(asked) if asked.is_campaign else of_cell(cell_given(asked.subject))
    subject = subject.keeping_out(asked.keep_outs())
    if asked.reading_mm is not None:
        subject = subject.reading(asked.reading_mm)
    return subject if discrepancy_mm is None else subject.lacking(discrepancy_mm)


def _of_campaign(asked: _PlanRequest) -> "Subject":
    from truepose.identification import identify
    from truepose.planning.prediction.robots_and_cells import of_campaign

    campaign = read_measured(Path(asked.subject))
    answer = identify(campaign)
    if answer.model is None:
        raise ConfigurationError(
            f"No accuracy can be predicted from this campaign: {english(answer.message)}"
        )
    nominal_mm = None if answer.judging is None else answer.judging.nominal.mean_mm
    return dataclasses.replace(of_campaign(campaign, answer.model), nominal_mm=nominal_mm)


def _for_ballbar(asked: _PlanRequest, discrepancy_mm: float | None) -> _RobotPlan:
    from truepose.domain.cell import BallbarKit
    from truepose.exchange.cells.file import cell_given
    from truepose.planning.prediction.ballbar import promised_ballbar_session, session_plan
    from truepose.planning.prediction.errors import Discrepancy
    from truepose.planning.prediction.robots_and_cells import expected_discrepancy
    from truepose.sessions.ballbar.dry_run import dry_run

    if asked.is_campaign:
        raise ConfigurationError("--ballbar plans for a robot or a cell file, not for a campaign; give one.")
    if asked.reading_mm is not None or asked.one_sided:
        raise ConfigurationError(
            "--reading-mm and --one-sided are for positions; leave them out with --ballbar."
        )
    cell = cell_given(asked.subject).keeping_out(asked.keep_outs())
    lack = expected_discrepancy(cell) if discrepancy_mm is None else Discrepancy(discrepancy_mm)
    volume = asked.work_volume(cell.robot)
    planned = functools.partial(promised_ballbar_session, cell, volume=volume, discrepancy=lack)
    plan = asked.tries.best(asked.n, planned)
    run = dry_run(session_plan(cell, plan), cell.ballbar or BallbarKit())
    return _RobotPlan(cell.robot, plan, run.duration_s / 60.0)


def _for_loop(asked: _PlanRequest, loop: _Loop, discrepancy_mm: float | None) -> _RobotPlan:
    from truepose.planning.contacts.loop_prediction import promised_loop
    from truepose.planning.prediction.tracker import session_plan
    from truepose.sessions.tracker.dry_run import minutes_of

    if asked.is_campaign or asked.one_sided:
        raise ConfigurationError(
            "--targets plans for a robot or a cell file, without --one-sided; give one of these."
        )
    subject = _subject(asked, discrepancy_mm)
    planned = functools.partial(
        promised_loop,
        subject.space,
        _wish(loop, subject.space.nests, asked.reading_mm),
        discrepancy=subject.knowns.discrepancy,
        volume=asked.work_volume(subject.space.robot),
    )
    plan = asked.tries.best(asked.n, planned)
    return _RobotPlan(subject.space.robot, plan, minutes_of(session_plan(plan), subject.space, 0))


def _wish(loop: _Loop, nests: "tuple[Nest, ...]", reading_mm: float | None) -> "LoopPlanRequest":
    from truepose.exchange.document import read_bytes
    from truepose.exchange.tables.contacts import read_distance_table, read_target_table
    from truepose.planning.contacts.loop_configurations import LoopPlanRequest

    targets, _ = read_target_table(loop.targets.name, read_bytes(loop.targets))
    distances = None
    if loop.distances is not None:
        distances, _ = read_distance_table(loop.distances.name, read_bytes(loop.distances), targets)
    used = loop.nests or tuple(range(1, len(nests) + 1))
    if used and not 1 <= min(used) <= max(used) <= len(nests):
        raise ConfigurationError(f"--nests {max(used)}: the tool has nests 1 to {len(nests)}.")
    return LoopPlanRequest(targets, used, _USUAL_READING_MM if reading_mm is None else reading_mm, distances)


def _write(file: Path, plan: "PromisedPlan") -> None:
    from truepose.exchange.tables.targets import write_plan

    with writing(file):
        write_plan(file, plan)


def _write_checklist(file: Path, made: _RobotPlan, name: str, language: str) -> None:
    from truepose.reports.checklist import ChecklistReport, checklist_of
    from truepose.reports.plans import promise_sentence

    words, listed = catalogue(language), checklist_of(made.plan)
    promise, outcome = (words.spoken(promise_sentence(made.plan)),), words.spoken(made.outcome)
    report = ChecklistReport(made.robot.name, name, listed, made.minutes, promise, outcome, language=language)
    report.write(file)


def _print(made: _RobotPlan, language: str, *, as_json: bool) -> None:
    from truepose.reports.plans import curve_table, plan_sentences
    from truepose.reports.tables import on_terminal

    sentences = list(plan_sentences(made.plan, made.minutes))
    if as_json:
        from truepose.exchange.results.plans import plan_document

        document = plan_document(
            made.plan, made.robot.name, made.minutes, sentences, made.nominal_mm, made.limit_mm
        )
        print_json(document.printed())
        return
    words = catalogue(language)
    print_lines(map(words.spoken, (made.outcome, *sentences)))
    print_tables(on_terminal(curve_table(made.plan, words)))
