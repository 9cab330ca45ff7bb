"""A file of targets corrected: a table some thousand rows at a time, or a robot program."""

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import BinaryIO, Final, TypeAlias

from truepose.correction import (
    OTHER_READINGS,
    Corrections,
    Goals,
    Summary,
    correct,
    goals_of_joints,
    in_world,
    likely_mistake,
)
from truepose.domain.arrays import IntArray
from truepose.domain.correction import CorrectionTotals, UncorrectedTarget
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model
from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.programs.correction_request import CorrectionRequest
from truepose.exchange.programs.formats import FORMATS, format_of, read_program, supported_files
from truepose.exchange.programs.program import UTF_16_MARKS, Program, TargetConventions
from truepose.exchange.programs.program_correction import corrected_program
from truepose.exchange.robots.named import with_known_limits
from truepose.exchange.tables.table_reader import TableData
from truepose.exchange.tables.targets import CorrectionWriter, Targets, targets_of
from truepose.messages.message import Message, message
from truepose.validation.cautions import prediction_cautions

TABLE: Final = ".csv"
_FEWEST: Final = 3  # targets out of reach: fewer are told one by one
_NEARLY_ALL: Final = 0.95
_AS_IT_IS: Final = CorrectionRequest()


@dataclass(frozen=True, slots=True)
class Rows:
    """Some targets of a file, and what became of them."""

    names: tuple[str, ...]  # (n,)
    lines: IntArray  # (n,) where they stand, from 1
    goals: Goals  # in the world
    found: Corrections
    share: float  # of the file that is done with them, 0 to 1


Seen: TypeAlias = Callable[[Rows], None]


@dataclass(slots=True)
class Answer:
    """What a file came to, beside its corrected text."""

    summary: Summary = field(default_factory=Summary)
    left_alone: tuple[UncorrectedTarget, ...] = ()
    cautions: tuple[Message, ...] = ()  # what the predictions do not contain, and what was not understood
    withheld: Message | None = None  # why the corrected text must not be used


def is_table(name: str) -> bool:
    """Whether a file is a table of targets, by the ending of its name."""
    return PurePath(name).suffix.lower() == TABLE


def correct_file(
    model: Model, name: str, data: bytes, asked: CorrectionRequest, out: BinaryIO, seen: Seen
) -> Answer:
    """Correct a file and write it again.

    Parameters
    ----------
    model : Model
    name : str
        Of the file; its ending says the format.
    data : bytes
        The file.
    asked : CorrectionRequest
    out : binary stream
        Takes the corrected file.
    seen : callable
        Is told of all targets, of a table some thousand at a time.

    Raises
    ------
    InputFileError
        The file cannot be used: its name, line and column.
    ConfigurationError
        It is of another robot, or the model needs measured torques.
    """
    _require_text(name, data)
    model = with_known_limits(model)
    correct_one = _correct_table if is_table(name) else _correct_program
    answer = correct_one(model, name, data, asked, out, seen)
    # Whoever says that the file is meant as it is written has seen the caution.
    if not asked.as_written:
        answer.withheld = reason_to_withhold(answer.cautions, answer.summary.totals)
    return answer


def _require_text(name: str, data: bytes) -> None:
    """Refuse a picture or an archive as what it is, before the ending of its name counts."""
    if b"\0" in data and not data.startswith(UTF_16_MARKS):
        raise UnreadableFileError(
            f"this is a binary file, not a robot program or a table; {supported_files()}", file=name
        )


def reason_to_withhold(cautions: tuple[Message, ...], totals: CorrectionTotals) -> Message | None:
    """Return why corrected targets must not be used: they are misread, or nearly all out of reach."""
    if any(caution.key in OTHER_READINGS for caution in cautions):
        return message("corrections.withheld.meant_otherwise")
    return _out_of_reach(totals)


def _out_of_reach(totals: CorrectionTotals) -> Message | None:
    """Return why nothing is written where nearly all targets are out of reach."""
    missed = totals.statuses.get("out_of_reach", 0)
    if missed < _FEWEST or missed < _NEARLY_ALL * totals.targets:
        return None
    return message("corrections.withheld.out_of_reach", missed=missed, targets=totals.targets)


def check_file(model: Model, name: str, data: bytes, asked: CorrectionRequest) -> int:
    """Return how many targets a file has that can be read; raises as `correct_file`."""
    _require_text(name, data)
    if is_table(name):
        return sum(len(part.names) for part in _parts(model, name, data, asked))
    program = _program(model, name, data, asked)
    for target in program.targets:
        target.known_rad(model.robot.n_joints)
    return len(program.targets)


def corrected_rows(
    model: Model, name: str, data: TableData, asked: CorrectionRequest = _AS_IT_IS
) -> Iterator[tuple[Targets, Rows]]:
    """Correct a table, some thousand rows at a time; raises as `correct_file`."""
    model = with_known_limits(model)
    for part in _parts(model, name, data, asked):
        goals = _goals(model, part, asked.meant)
        found = correct(model, goals, part.branch)
        yield part, Rows(part.names, part.lines, goals, found, part.share)


def _correct_table(
    model: Model, name: str, data: bytes, asked: CorrectionRequest, out: BinaryIO, seen: Seen
) -> Answer:
    answer = Answer()
    begun = False
    text = io.TextIOWrapper(out, encoding="utf-8", newline="\n")
    writer = CorrectionWriter(text)
    for part, rows in corrected_rows(model, name, data, asked):
        if not begun:
            # Of the first rows alone: a table in a wrong unit or frame is so from its beginning, and its rows
            # are not kept.
            answer.cautions, begun = table_cautions(model, part, rows, asked.meant), True
        writer.write(rows.names, rows.found, part.own)
        answer.summary.add(rows.names, rows.found)
        seen(rows)
    text.detach()  # flushed; whoever opened the stream closes it
    return answer


def table_cautions(
    model: Model, part: Targets, rows: Rows, meant: TargetConventions | None
) -> tuple[Message, ...]:
    """Return what was not understood of a table, or wrongly, and what its predictions do not contain."""
    mistake = part.poses and likely_mistake(model, part.poses, in_base=meant is TargetConventions.BASE)
    return (
        *([mistake] if mistake else []),
        *part.ignored,
        *prediction_cautions(model, rows.goals.at(rows.found.joints_rad)),
    )


def _parts(model: Model, name: str, data: TableData, asked: CorrectionRequest) -> Iterator[Targets]:
    nests = [nest.nest for nest in model.nests]
    most = {} if asked.most_targets is None else {"most_rows": asked.most_targets}
    return targets_of(name, data, model.robot.n_joints, nests, **most)


def _goals(model: Model, part: Targets, meant: TargetConventions | None) -> Goals:
    if part.poses is None:
        return goals_of_joints(model, part.stops)
    return in_world(model, part.poses) if meant is TargetConventions.BASE else part.poses


def _correct_program(
    model: Model, name: str, data: bytes, asked: CorrectionRequest, out: BinaryIO, seen: Seen
) -> Answer:
    program = _program(model, name, data, asked)
    corrected = corrected_program(model, program, asked.understood)
    out.write(corrected.data)
    answer = Answer(Summary(), corrected.left_alone, corrected.cautions)
    answer.summary.add(corrected.names, corrected.found)
    seen(Rows(corrected.names, corrected.lines, corrected.goals, corrected.found, 1.0))
    return answer


def _program(model: Model, name: str, data: bytes, asked: CorrectionRequest) -> Program:
    """Read a program; raises as `correct_file`."""
    # Before the file is read: of another maker's arm every target would be refused for reasons that explain
    # nothing.
    _require_maker(model, name)
    program = read_program(data, name, beside=asked.beside, angles=asked.angles)
    if asked.most_targets is not None and len(program.targets) > asked.most_targets:
        raise UnreadableFileError(
            f"the program has more than {asked.most_targets:,} targets, the limit for one correction",
            file=name,
        )
    return program


def _require_maker(model: Model, name: str) -> None:
    """Refuse a program in the language of one maker for a robot that is named after another one."""
    maker = format_of(name).maker
    rivals = [known.maker for known in FORMATS if known.maker not in ("", maker)]
    if maker and any(rival.casefold() in model.robot.name.casefold() for rival in rivals):
        raise ConfigurationError(
            f"{name} is a program for {maker} robots, but the model is of {model.robot.name}: use "
            "the model of the robot that runs the program."
        )
