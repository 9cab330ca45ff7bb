"""Which stops a recorded campaign makes: where, when, from which side, with which mounting of the tool."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ScenarioError, SimulatorError
from truepose_simulators.instruments.tracker import cosine_to_beam
from truepose_simulators.physics.effects import Conditions
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.rigid import FloatArray, apply, move
from truepose_simulators.recording.nominal_tables import papers_of_cell
from truepose_simulators.recording.rows import Rows

APPROACHES = ("mixed", "from_below")
_CALIBRATION_S = 28.0  # a stop with its way there, settling, search and reading
_VALIDATION_S = 12.0  # the same without pauses for the reference nests
_TIME_SPREAD = 0.2
_LOWEST_NEST_MM = 80.0  # no nest closer to the table
_CANDIDATES_PER_STOP = 12  # about one in four shows a nest
_MOST_DRAWS = 20


class NoStopsError(SimulatorError):
    """The tracker sees too few configurations of this cell."""


@dataclass(frozen=True, slots=True)
class RecordingRequest:
    """What a recorded campaign should be."""

    configurations: int = 100
    validation: int = 300
    revisits: int = 0  # how many of the configurations are visited again at the end
    approach: str = "mixed"  # from configuration to configuration, or every joint "from_below"
    attachments: int = 4  # mountings of the tool, in equal parts of the calibration
    reference_every: int = 10  # stops between readings of the fixed nests; 0: none

    def __post_init__(self) -> None:
        for name, least in (
            ("configurations", 1),
            ("attachments", 1),
            ("validation", 0),
            ("reference_every", 0),
        ):
            if getattr(self, name) < least:
                raise ScenarioError(f'"{name}" must be {least} or more, not {getattr(self, name)}')
        if not 0 <= self.revisits <= self.configurations:
            raise ScenarioError(f'"revisits" must be 0 to {self.configurations}, not {self.revisits}')
        check_approach(self.approach)


def check_approach(approach: str) -> None:
    """Raise ScenarioError for a way to come to the stops that there is not."""
    if approach not in APPROACHES:
        raise ScenarioError(f'"approach" must be {" or ".join(APPROACHES)}, not "{approach}"')


@dataclass(frozen=True, slots=True)
class Stops(Rows):
    """n stops in the order in which they are made."""

    joints_deg: FloatArray  # (n, J) with the decimals of the file
    direction: FloatArray  # (n, J)
    time_s: FloatArray  # (n,)
    attachment: FloatArray  # (n,)
    nest: NestNumbers  # (n,) the one that faces the tracker best, 1-based
    repeat_of: NestNumbers  # (n,) number of the stop that is visited again, 0 for a new one

    def conditions(self, cell: Cell) -> Conditions:
        """Return the circumstances of the stops in a cell."""
        return cell.conditions(np.radians(self.joints_deg), self.direction, self.time_s, self.attachment)


def plan_stops(cell: Cell, wishes: RecordingRequest, rng: np.random.Generator) -> Stops:
    """Choose all stops, calibration (with revisits at its end) before validation; raises NoStopsError."""
    n_new = wishes.configurations + wishes.validation
    joints, nests = _visible_configurations(cell, n_new, rng)
    again = rng.permutation(wishes.configurations)[: wishes.revisits]
    order = np.concatenate([np.arange(wishes.configurations), again, np.arange(wishes.configurations, n_new)])
    n_calibration = wishes.configurations + wishes.revisits
    repeat_of = np.zeros(len(order), dtype=int)
    repeat_of[wishes.configurations : n_calibration] = again + 1
    return Stops(
        joints_deg=joints[order],
        direction=directions(joints[order], wishes.approach),
        time_s=_times_s(n_calibration, wishes.validation, rng),
        attachment=_attachments(n_calibration, wishes),
        nest=nests[order],
        repeat_of=repeat_of,
    )


def _visible_configurations(cell: Cell, n: int, rng: np.random.Generator) -> tuple[FloatArray, NestNumbers]:
    """Draw configurations in which a nest faces the tracker, and which one does."""
    lower, upper = np.array(papers_of_cell(cell).calibration_deg).T
    joints, nests = np.zeros((0, len(lower))), np.zeros(0, dtype=int)
    for _ in range(_MOST_DRAWS):
        # Rounded before anything is computed: the truth beside a campaign is of the joints that its file
        # states.
        drawn = np.round(rng.uniform(lower, upper, (_CANDIDATES_PER_STOP * n, len(lower))), 5)
        nest, seen = _best_nest(cell, drawn)
        joints, nests = np.concatenate([joints, drawn[seen]]), np.concatenate([nests, nest[seen]])
        if len(joints) >= n:
            return joints[:n], nests[:n]
    raise NoStopsError(f"the tracker sees a nest in {len(joints)} configurations only; {n} are required")


def _best_nest(cell: Cell, joints_deg: FloatArray) -> tuple[NestNumbers, NestNumbers]:
    """Nest that faces the tracker best (1-based), and the rows in which it is seen and clear of the table."""
    tool = cell.scenario.tool
    # A drawn base is off by tenths of a millimetre, which hides no nest; that of a model may stand anywhere.
    base = np.eye(4) if cell.model is None else cell.plant.errors[0]
    flange = base @ nominal_flange(cell.plant.arm, np.radians(joints_deg))
    positions = move(flange[:, np.newaxis], np.array(tool.nests_mm))
    facing = apply(flange[:, np.newaxis, :3, :3], cell.facing)
    stand = np.eye(4)
    stand[:3, 3] = cell.scenario.tracker.position_mm
    cosine = cosine_to_beam(stand, positions, facing)
    in_sight = cosine.max(axis=1) >= np.cos(np.radians(tool.acceptance_deg))
    clear = positions[..., 2].min(axis=1) >= _LOWEST_NEST_MM
    return cosine.argmax(axis=1) + 1, np.flatnonzero(in_sight & clear)


def directions(joints_deg: FloatArray, approach: str) -> FloatArray:
    """Sign of every joint's last motion before each stop, the first coming from zero, shape (n, J)."""
    if approach == "from_below":
        return np.ones_like(joints_deg)
    home = np.zeros((1, joints_deg.shape[1]))
    steps: FloatArray = np.diff(joints_deg, axis=0, prepend=home)
    return np.sign(steps)


def _times_s(n_calibration: int, n_validation: int, rng: np.random.Generator) -> FloatArray:
    mean_s = np.concatenate([np.full(n_calibration, _CALIBRATION_S), np.full(n_validation, _VALIDATION_S)])
    steps = mean_s * (1.0 + _TIME_SPREAD * rng.uniform(-1.0, 1.0, len(mean_s)))
    times: FloatArray = np.cumsum(steps).round(1)
    return times


def _attachments(n_calibration: int, wishes: RecordingRequest) -> FloatArray:
    """Return the number of the mounting at every stop; the last one stays on for the validation."""
    parts = np.arange(n_calibration) * wishes.attachments // n_calibration + 1.0
    return np.concatenate([parts, np.full(wishes.validation, float(wishes.attachments))])
