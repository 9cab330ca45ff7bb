"""A robot program corrected: its targets sent through the inverse of the identified model.

A target with joint angles is what the controller itself answers with; the place meant is where its nominal
model has the flange then. A target with a pose is the place of its tool in its work object. Either is meant
in the robot's own base, or in the world of the readings. What goes back into the program are joint angles, or
the pose at which the *nominal* model has the corrected joint angles: the controller finds these again.

The flange of the controller must be the flange frame of the nominal table: so it is in the tables that ship.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.correction import (
    ANY_BRANCH,
    FLANGE,
    Corrections,
    Goals,
    correct,
    flange_in_base,
    in_world,
    tool_nests_mm,
)
from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.correction import UncorrectedTarget
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model
from truepose.exchange.programs.correction_request import branch_of_words
from truepose.exchange.programs.formats import format_of
from truepose.exchange.programs.joints_reached import (
    Controller,
    approach_directions,
    befores,
    can_be_coupled,
    from_horizontal,
    uncouple,
)
from truepose.exchange.programs.languages.json_list import nest_frame
from truepose.exchange.programs.number_replacement import rewritten
from truepose.exchange.programs.program import (
    AT_THE_ORIGIN,
    Configuration,
    Frame,
    Pose,
    Program,
    ProgramOptions,
    ProgramTarget,
    TargetConventions,
    Value,
)
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import poses_of, quaternion_from_rotation, rotation_from_quaternion
from truepose.messages.message import Message, message
from truepose.validation.cautions import prediction_cautions

_COUNTS_FROM_THE_HORIZONTAL: Final = "FANUC LS"
_COUPLED: Final = message("left.from_the_horizontal")


@dataclass(frozen=True, slots=True)
class CorrectedProgram:
    """A program, what became of each of its targets, and the file again."""

    program: Program
    corrected: tuple[int, ...]  # indices of the targets of the rows of `found`
    goals: Goals  # of these, in the world
    found: Corrections
    left_alone: tuple[UncorrectedTarget, ...]  # also targets whose frames the file does not declare
    cautions: tuple[Message, ...]  # what the predictions do not contain
    data: bytes

    @property
    def lines(self) -> IntArray:
        """Lines of the targets of `found`, shape (n,)."""
        return np.array([self.program.targets[index].line for index in self.corrected], dtype=np.int64)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the targets of `found`."""
        return tuple(self.program.targets[index].name for index in self.corrected)


_AS_IT_IS: Final = ProgramOptions()


def corrected_program(
    model: Model, program: Program, understood: ProgramOptions = _AS_IT_IS
) -> CorrectedProgram:
    """Correct every target of a program as far as that can be done by changing its numbers.

    Parameters
    ----------
    model : Model
    program : Program
    understood : ProgramOptions, optional

    Returns
    -------
    CorrectedProgram
        Targets that were not solved keep their numbers.

    Raises
    ------
    ConfigurationError
        The program is of an arm with another number of joints, the model needs measured torques, or a tool or
        work object is defined that the program does not name.
    """
    _require_named(program, understood.defined)
    counted = program.format == _COUNTS_FROM_THE_HORIZONTAL
    # How FANUC counts joint 3 is for the user to say; assumed wrongly, every joint target would be off by the
    # angle of joint 2.
    coupled = counted and understood.coupled and can_be_coupled(model.robot)

    def known(read: Program) -> Program:
        """Return a program as it is read, with frames that it only names, and joints as the model counts."""
        framed = _with_frames(read, _nests(model) | dict(understood.defined))
        return uncouple(model.robot, framed) if coupled else framed

    written, program = program, known(program)
    run = _Run(model, program, understood)
    reasons = {
        index: _COUPLED
        if counted and not coupled and isinstance(target.value, Configuration)
        else run.reason_against(target)
        for index, target in enumerate(program.targets)
    }
    # What contradicts itself before it is corrected cannot be: where its controller goes is not what it says
    # (decision 0071).
    reasons |= run.started([index for index, reason in reasons.items() if reason is None])
    rows = tuple(index for index, reason in reasons.items() if reason is None)
    goals, found = run.found(rows)
    values = _values(model, program, rows, found, coupled=coupled)
    data, missed = run.read_back(written, known, rows, found, values)
    reasons |= dict.fromkeys(missed, message("left.not_arriving"))
    kept = np.array([place for place, index in enumerate(rows) if index not in missed], dtype=np.int64)
    left = tuple(
        UncorrectedTarget(program.targets[index].line, program.targets[index].name, reason)
        for index, reason in reasons.items()
        if reason is not None
    )
    goals, found = goals.taken(kept), found.taken(kept)
    cautions = tuple(prediction_cautions(model, goals.at(found.joints_rad))) if len(kept) else ()
    corrected = tuple(index for index in rows if index not in missed)
    everything = sorted((*program.left_beside(corrected), *left), key=lambda one: one.line)
    return CorrectedProgram(written, corrected, goals, found, tuple(everything), cautions, data)


def _nests(model: Model) -> dict[str, Pose]:
    """Return the tool nests as tools, by the names that lists of targets give them."""
    places = enumerate(tool_nests_mm(model).tolist(), start=1)
    return {nest_frame(nest).name: Pose((x, y, z), AT_THE_ORIGIN.quaternion) for nest, (x, y, z) in places}


def _require_named(program: Program, defined: Mapping[str, Pose]) -> None:
    frames = [frame for target in program.targets for frame in (target.tool, target.work_object)]
    named = dict.fromkeys(frame.name for frame in frames if frame is not None)
    known = {name.casefold() for name in named}
    for name in defined:
        if name.casefold() not in known:
            there = f"it names {', '.join(named)}" if named else "it names none"
            raise ConfigurationError(f"{program.name} names no tool or work object {name}; {there}.")


def _with_frames(program: Program, defined: Mapping[str, Pose]) -> Program:
    by_name = {name.casefold(): pose for name, pose in defined.items()}

    def known(frame: Frame | None) -> Frame | None:
        if frame is None or frame.pose is not None:
            return frame
        return replace(frame, pose=by_name.get(frame.name.casefold()))

    return replace(
        program,
        targets=tuple(
            replace(target, tool=known(target.tool), work_object=known(target.work_object))
            for target in program.targets
        ),
    )


class _Run:
    """A program, and the controller that runs it."""

    def __init__(self, model: Model, program: Program, understood: ProgramOptions) -> None:
        self._model, self._program, self._understood = model, program, understood
        self._rule = format_of(program.name).rule
        self._controller = Controller(model.robot, self._rule)
        self._branch = [_branch(target, understood) for target in program.targets]
        self._many = self._says_many_branches()
        self._befores = befores(program)
        self._own: dict[int, FloatArray] = {}  # joints that the controller takes to the file as it is

    def reason_against(self, target: ProgramTarget) -> Message | None:
        """Say why a target cannot be corrected, by what the file says of it; None where it can."""
        if self._rule.moves_external(target.external):
            return message("left.external")
        if isinstance(target.value, Configuration):
            return None
        reason = _reason_against_frames(target)
        if reason is not None:
            return reason
        if self._rule.counts_turns(target.branch):
            return message("left.turns", words=target.branch)
        branch = _branch(target, self._understood)
        if not self._controller.can_tell(target, branch):
            return message("left.branch_unknown")
        if self._many and target.near_rad is None and branch_of_words(target.branch) is None:
            return message("left.many_branches", words=self._many)
        return None

    def started(self, rows: Sequence[int]) -> dict[int, Message | None]:
        """Find the joints that the controller takes as the file is; return what contradicts itself."""
        targets = [self._program.targets[index] for index in rows]
        flange = _own_flanges(self._model, targets, self._understood.meant)
        told = [target.known_rad(self._model.robot.n_joints) for target in targets]
        self._own = {
            index: np.array(joints)
            for index, target, joints in zip(rows, targets, told, strict=True)
            if isinstance(target.value, Configuration)
        }
        answers = self._controller.answers(flange)
        for place, (index, target) in enumerate(zip(rows, targets, strict=True)):
            if index not in self._own:
                before = next(iter(self._before(index, self._own)), None)
                taken = self._controller.taken(target, answers[place], self._branch[index], before)
                self._own |= {} if taken is None else {index: taken}
        reached = {
            index: place
            for place, index in enumerate(rows)
            if index in self._own and np.isfinite(self._own[index]).all()
        }
        places = list(reached.values())
        arrives = self._arriving(list(reached), [targets[p] for p in places], flange[places], self._own)
        contradicted = [index for index, there in zip(reached, arrives, strict=True) if not there]
        return {
            index: message("left.contradicts")
            for index in (*contradicted, *(index for index in rows if index not in self._own))
        }

    def found(self, rows: Sequence[int]) -> tuple[Goals, Corrections]:
        """Correct targets, once more where the model asks from which side their joints come."""
        targets = [self._program.targets[index] for index in rows]
        near = np.array([self._own[index] for index in rows]).reshape(len(rows), self._model.robot.n_joints)
        goals = _goals(self._model, targets, near, self._understood.meant)
        branch = np.array([self._branch[index] for index in rows], dtype=np.int64)
        found = correct(self._model, goals, branch)
        directions = approach_directions(self._program, rows, found.joints_rad)
        if not directions.any():
            return goals, found
        # Only the directions change. The search begins again at the controller's own joints, from which turns
        # are counted.
        goals = replace(goals, stops=replace(goals.stops, direction=directions))
        return goals, correct(self._model, goals, branch)

    def read_back(
        self,
        written: Program,
        known: Callable[[Program], Program],
        rows: Sequence[int],
        found: Corrections,
        values: dict[int, Value],
    ) -> tuple[bytes, set[int]]:
        """Return the file with the values at which the controller arrives at what was found, and the others.

        A target that is left alone changes from where the next one is reached: until nothing is left alone.
        """
        sent = {index: found.joints_rad[row] for row, index in enumerate(rows) if index in values}
        missed: set[int] = set()
        while True:
            data = rewritten(written, values, {index: self._turned(index, sent[index]) for index in values})
            again = known(written.again(data)) if written.again and values else None
            # Each round leaves out a target at least, so that this ends.
            now = self._missing(again, sent) if again else []
            if not now:
                return data, missed
            missed |= set(now)
            for index in now:
                del sent[index], values[index]

    def _missing(self, again: Program, sent: Mapping[int, FloatArray]) -> list[int]:
        targets = [again.targets[index] for index in sent]
        arrives = self._arriving(list(sent), targets, _flanges(self._model, targets), {**self._own, **sent})
        return [index for index, there in zip(sent, arrives, strict=True) if not there]

    def _arriving(
        self,
        rows: Sequence[int],
        targets: Sequence[ProgramTarget],
        flange: FloatArray,
        joints: Mapping[int, FloatArray],
    ) -> list[bool]:
        befores = [self._before(index, joints) for index in rows]
        wanted = np.array([joints[index] for index in rows])
        return self._controller.arriving(targets, flange, [self._branch[i] for i in rows], wanted, befores)

    def _before(self, index: int, joints: Mapping[int, FloatArray]) -> list[FloatArray]:
        """Return the joints from which the robot moves to a target, as far as they are known."""
        return [joints[before] for before in self._befores.get(index, ()) if before in joints]

    def _turned(self, index: int, sent_rad: FloatArray) -> tuple[int, ...]:
        target = self._program.targets[index]
        return self._controller.turned(target, self._branch[index], self._own[index], sent_rad)

    def _says_many_branches(self) -> str:
        """Return the words by which a file names several branches, though one was stated for all."""
        asked = [
            target
            for target in self._program.targets
            if isinstance(target.value, Pose) and branch_of_words(target.branch) is None and target.branch
        ]
        # One branch was stated for all: where the file names several, it would send some of them into another
        # posture.
        postures = dict.fromkeys(self._rule.posture(target.branch) for target in asked)
        return "; ".join(postures) if len(postures) > 1 else ""


def _reason_against_frames(target: ProgramTarget) -> Message | None:
    if target.tool is None or target.work_object is None:
        return message("left.tool_unsaid") if target.tool is None else message("left.object_unsaid")
    if target.tool.pose is None:
        return message("left.tool_undeclared", frame=target.tool.shown)
    if target.work_object.pose is None:
        return message("left.object_undeclared", frame=target.work_object.shown)
    return None


def _goals(
    model: Model, targets: Sequence[ProgramTarget], near_rad: FloatArray, meant: TargetConventions
) -> Goals:
    flange = _flanges(model, targets)
    stops = Stops(np.arange(len(targets)), near_rad)
    goals = Goals(stops, np.full(len(targets), FLANGE), flange[:, :3, 3], flange[:, :3, :3])
    return goals if meant is TargetConventions.WORLD else in_world(model, goals)


def _own_flanges(model: Model, targets: Sequence[ProgramTarget], meant: TargetConventions) -> FloatArray:
    """Return where targets have the controller's flange, in the robot's base, shape (n, 4, 4)."""
    flange = _flanges(model, targets)
    if meant is TargetConventions.BASE or not targets:
        return flange
    near = np.full((len(targets), model.robot.n_joints), np.nan)
    return flange_in_base(model, _goals(model, targets, near, meant))


def _branch(target: ProgramTarget, understood: ProgramOptions) -> int:
    told = branch_of_words(target.branch)
    found = understood.branch if told is None else told
    return ANY_BRANCH if found is None else found


def _flanges(model: Model, targets: Sequence[ProgramTarget]) -> FloatArray:
    """Return where targets have the controller's flange, in the frame that they are meant in, (n, 4, 4)."""
    found = np.array([_placed_flange(target) for target in targets]).reshape(len(targets), 4, 4)
    told = [row for row, target in enumerate(targets) if isinstance(target.value, Configuration)]
    if told:
        joints = np.array([targets[row].known_rad(model.robot.n_joints) for row in told])
        # A configuration says where the controller believes its flange to be, which is what its nominal table
        # says.
        found[told] = _nominal_flange(model, joints)
    return found


def _placed_flange(target: ProgramTarget) -> FloatArray:
    """Return where a pose has the flange; of a configuration nothing yet."""
    if isinstance(target.value, Configuration):
        return np.eye(4)
    tool, work_object = _frames(target)
    return np.asarray(work_object @ _matrix(target.value) @ np.linalg.inv(tool))


def _frames(target: ProgramTarget) -> tuple[FloatArray, FloatArray]:
    """Return tool and work object of a target that can be corrected."""
    tool, work_object = (
        frame.pose if frame and frame.pose else AT_THE_ORIGIN for frame in (target.tool, target.work_object)
    )
    return _matrix(tool), _matrix(work_object)


def _nominal_flange(model: Model, joints_rad: FloatArray) -> FloatArray:
    """Return where the controller believes its flange to be, in its base, shape (n, 4, 4)."""
    chain = nominal_chain(model.robot, joints_rad)
    return poses_of(chain.end_rotation, chain.end_origin)


def _matrix(pose: Pose) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_from_quaternion(np.array(pose.quaternion))
    matrix[:3, 3] = pose.position_mm
    return matrix


def _values(
    model: Model, program: Program, rows: Sequence[int], found: Corrections, *, coupled: bool
) -> dict[int, Value]:
    """Return what to write for the targets that were solved."""
    flange = _nominal_flange(model, np.nan_to_num(found.joints_rad))
    values: dict[int, Value] = {}
    for row in np.flatnonzero(found.solved).tolist():
        target = program.targets[rows[row]]
        if isinstance(target.value, Configuration):
            joints = Configuration(tuple(found.joints_rad[row].tolist()))
            values[rows[row]] = from_horizontal(model.robot, joints) if coupled else joints
        else:
            tool, work_object = _frames(target)
            values[rows[row]] = _pose(np.linalg.inv(work_object) @ flange[row] @ tool)
    return values


def _pose(matrix: FloatArray) -> Pose:
    x, y, z = matrix[:3, 3].tolist()
    qw, qx, qy, qz = quaternion_from_rotation(matrix[:3, :3]).tolist()
    return Pose((x, y, z), (qw, qx, qy, qz))
