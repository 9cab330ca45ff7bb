"""Programs of drawn targets, corrected, and run by controllers of another make.

What a controller takes is found from the bytes of the file by `other_controller` and `drawn_languages`,
which know neither the readers nor the rules of the product.
"""

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tests.helpers.exchange import drawn_languages as languages
from tests.helpers.exchange.drawn_joints import drawn_joints, erring_model
from truepose.exchange.programs.formats import read_program
from truepose.exchange.programs.program import AT_THE_ORIGIN, ProgramOptions
from truepose.exchange.programs.program_correction import corrected_program
from truepose.exchange.robots.named import load_robot
from truepose.kinematics.inverse import branch_of

_SAME = np.radians(0.03)  # a file has three decimals, and a singular wrist enlarges them
_FRAMES = dict.fromkeys(("TOOL 0", "T1", "G54"), AT_THE_ORIGIN)


@dataclass
class Language:
    """How targets are written, and what the controller takes to what stands there."""

    robot: str
    name: str
    write: Callable
    taken: Callable
    judged: str = ""  # how names of targets begin that are looked at; "": all


@dataclass
class Counted:
    """What became of drawn targets."""

    drawn: int
    corrected: int = 0
    elsewhere: int = 0  # corrected ones to which the controller takes other joints than were solved
    alone: Counter = field(default_factory=Counter)


def tried(language, n, seed, size=1.0, *, hard=True):
    """Draw targets, have them corrected, and let another controller run the corrected file."""
    robot = load_robot(language.robot)
    model, joints = erring_model(robot, seed, size), drawn_joints(robot, n, seed, hard=hard)
    branch = branch_of(robot, joints)
    count = Counted(len(joints))
    for number in range(8):
        if (branch == number).any():
            _try(count, language, model, joints[branch == number], number)
    return count


def _try(count, language, model, own, number):
    data = language.write(model.robot, own)
    program = read_program(data, language.name, angles="zyx")
    frames = {frame.name for one in program.targets for frame in (one.tool, one.work_object) if frame}
    defined = {name: pose for name, pose in _FRAMES.items() if name in frames}
    answer = corrected_program(model, program, ProgramOptions(branch=number, defined=defined))
    judged = np.array([name.startswith(language.judged) for name in answer.names], dtype=bool)
    solved = np.flatnonzero(answer.found.solved & judged)
    rows = _places(program, [answer.corrected[row] for row in solved], len(own))
    taken = language.taken(model.robot, answer.data, own)[rows]
    off = np.abs(taken - answer.found.joints_rad[solved]).max(axis=1, initial=0.0)
    count.corrected += len(rows)
    count.elsewhere += int((~(off <= _SAME)).sum())
    count.alone.update(left.reason.key for left in answer.left_alone if left.what.startswith(language.judged))
    count.alone.update(map(str, answer.found.status[~answer.found.solved & judged]))


def _places(program, targets, drawn):
    """The number of each target among those that were drawn: of its name, or of its line."""
    first = program.targets[0].line
    found = []
    for target in targets:
        name = program.targets[target].name
        number = re.fullmatch(r"[A-Za-z]+\[?([0-9]+)\]?", name)
        found.append(int(number[1]) if number else program.targets[target].line - first)
    assert all(place < drawn for place in found)
    return np.array(found, dtype=int)


LANGUAGES = {
    "RAPID": Language("abb-irb-120", "m.mod", languages.rapid, languages.taken_by_abb),
    "RAPID, joints": Language("abb-irb-120", "m.mod", languages.rapid_joints, languages.taken_as_joints),
    "RAPID, offset shoulder": Language(
        "fanuc-lr-mate-200ic", "m.mod", languages.rapid, languages.taken_by_abb
    ),
    "KRL": Language("kuka-kr-6-r900-sixx", "m.src", languages.krl, languages.taken_by_kuka),
    "FANUC LS": Language("fanuc-lr-mate-200ic", "m.ls", languages.fanuc, languages.taken_by_fanuc),
    "INFORM": Language("abb-irb-120", "m.jbi", languages.inform, languages.taken_by_yaskawa),
    "G-code": Language("kuka-kr-6-r900-sixx", "m.nc", languages.gcode, languages.taken_by_machine),
    "URScript": Language("universal-robots-ur10", "m.script", languages.script, languages.taken_by_ur),
    "URScript, moves": Language(
        "universal-robots-ur10", "m.script", languages.script_of_moves, languages.taken_by_ur, "p"
    ),
    "JSON": Language("abb-irb-120", "m.json", languages.listed, languages.taken_of_list),
}
