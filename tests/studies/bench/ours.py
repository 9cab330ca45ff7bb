"""What truepose does, in process and as a whole process."""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from scipy.spatial.distance import pdist

from tests.studies.bench.timing import Timing, timed
from truepose.correction import Goals, correct
from truepose.correction.branches import attain_branch
from truepose.domain.campaign import Campaign, PointReadings, Stops
from truepose.domain.identification import Model, Parameter
from truepose.domain.robot import FramePlacement
from truepose.exchange.campaigns.folder import write_campaign
from truepose.exchange.robots.named import load_robot_with_tool
from truepose.identification import identify
from truepose.identification.fit.robust import fit
from truepose.identification.model.estimates import identified_estimate, structure_of, values_of
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.problem.build import automatic_effects, build
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.inverse import all_branches, branch_of
from truepose.planning.exchange_algorithm import choose_by_exchange
from truepose.planning.observability import observability_o1
from truepose.validation.distance_errors import pair_errors

_NOISE_MM: Final = 0.015
_LOOP: Final = "s = 0\nfor i in range(10**7):\n    s += i * i"
CHOSEN: Final = 38
STARTS: Final = 20


def campaign(n: int) -> Campaign:
    """Return an IRB 120 whose parameters are off by a fifth of their prior widths, measured with noise."""
    shipped = load_robot_with_tool("abb-irb-120")
    rng = np.random.default_rng(n)
    ranges = shipped.robot.calibration_ranges or ()
    joints = rng.uniform([r.lower_rad for r in ranges], [r.upper_rad for r in ranges], (n, len(ranges)))
    targets = Targets(Stops(np.arange(n), joints), 1 + np.arange(n) % len(shipped.nests))
    centres = np.array([nest.centre_mm for nest in shipped.nests])
    places = nominal_chain(shipped.robot, joints).points(centres[targets.nest - 1])
    nominal = _read(shipped, targets, places)
    structure = build(nominal, automatic_effects(nominal)).structure
    widths = np.minimum(structure.prior_widths, 1.0)
    true = structure.prior_means + 0.2 * widths * rng.standard_normal(len(widths))
    seen = evaluate(structure, true, targets).position_mm + _NOISE_MM * rng.standard_normal((n, 3))
    return _read(shipped, targets, seen)


def _read(shipped, targets: Targets, places_mm: np.ndarray) -> Campaign:
    readings = PointReadings(targets.stops, targets.nest, places_mm, np.full(len(targets), _NOISE_MM))
    return Campaign(shipped.robot, FramePlacement(), shipped.nests, calibration=readings)


def identifications(n: int) -> Iterator[tuple[str, Timing]]:
    """Time an identification of n readings as a whole, and the weighted solution with covariance in it."""
    read = campaign(n)
    problem = build(read, automatic_effects(read))
    yield "identify, whole answer", timed(lambda: identify(read))
    yield (
        "bare solution with covariance",
        timed(lambda: fit(problem.structure, problem.blocks, problem.structure.prior_means)),
    )


def forward_kinematics(n: int) -> Iterator[tuple[str, Timing]]:
    """Time the frames of n configurations, of the nominal arm and of an identified one with its torques."""
    read = campaign(n)
    problem = build(read, automatic_effects(read))
    structure, targets = problem.structure, problem.blocks[0].targets
    values = fit(structure, problem.blocks, structure.prior_means).values
    joints = targets.stops.joints_rad
    yield "forward kinematics, nominal", timed(lambda: nominal_chain(read.robot, joints))
    yield "forward kinematics, identified with torques", timed(lambda: evaluate(structure, values, targets))


def inverses(n: int) -> Iterator[tuple[str, Timing]]:
    """Time the inverse of n poses, nominal and of an identified model, without and with joint curves."""
    read = campaign(1000)
    model = identify(read).model
    if model is None:
        raise SystemExit("the bench's campaign could not be identified")
    ranges = read.robot.calibration_ranges or ()
    rng = np.random.default_rng(n)
    joints = rng.uniform([r.lower_rad for r in ranges], [r.upper_rad for r in ranges], (n, len(ranges)))
    branch = branch_of(read.robot, joints)
    chain = nominal_chain(read.robot, joints)
    poses = _poses(chain.end_origin, chain.end_rotation)
    yield "nominal inverse, 8 branches", timed(lambda: all_branches(read.robot, poses))
    for name, plant in (("identified model", model), ("with joint curves of 60 orders", _with_curves(model))):
        goals, estimate = _goals(plant, joints), identified_estimate(plant)
        solved = attain_branch(estimate, goals, branch).arrived.mean()
        yield (
            f"inverse, {name} ({solved:.2%} solved)",
            timed(lambda estimate=estimate, goals=goals: attain_branch(estimate, goals, branch)),
        )
    goals = _goals(model, joints)
    yield "targets corrected, with uncertainties", timed(lambda: correct(model, goals, branch))


def _with_curves(model: Model) -> Model:
    """Return a model whose six joints are off by curves of sixty orders, some hundredths of a degree."""
    names = [f"wave_{j}_{o}_{phase}" for j in range(1, 7) for o in range(1, 61) for phase in ("sin", "cos")]
    values = np.deg2rad(0.005) * np.random.default_rng(0).standard_normal(len(names))
    waves = tuple(
        Parameter(name, "joint_harmonics", float(value), "rad", 0.0, 1.0)
        for name, value in zip(names, values, strict=True)
    )
    size = len(model.parameters)
    covariance = np.zeros((size + len(waves),) * 2)
    covariance[:size, :size] = model.covariance
    effects = (*model.effects, "joint_harmonics")
    return replace(model, parameters=(*model.parameters, *waves), covariance=covariance, effects=effects)


def _goals(model: Model, joints: np.ndarray) -> Goals:
    """Return goals of the first nest that the identified arm can reach."""
    stops, nest = Stops(np.arange(len(joints)), joints), np.ones(len(joints), dtype=np.int64)
    state = evaluate(structure_of(model), values_of(model), Targets(stops, nest))
    unknown = replace(stops, joints_rad=np.full_like(joints, np.nan))
    return Goals(unknown, nest, state.unscaled_mm, state.chain.end_rotation)


def _poses(origin_mm: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    poses = np.tile(np.eye(4), (len(origin_mm), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = rotation, origin_mm
    return poses


def pair_distances(n: int) -> Iterator[tuple[str, Timing]]:
    """Time the errors of the distances between all pairs of n points, of one model and of two."""
    rng = np.random.default_rng(0)
    seen = rng.uniform(-700.0, 700.0, (n, 3))
    models = [seen + error_mm * rng.standard_normal((n, 3)) for error_mm in (0.15, 1.3)]
    pairs = f"{n * (n - 1) // 2:,} pairs"
    yield f"distances of {pairs}", timed(lambda: pair_errors(seen, models[:1]))
    yield f"distances of {pairs}, two models", timed(lambda: pair_errors(seen, models))
    yield f"scipy pdist: distances of {pairs}, no histogram", timed(lambda: pdist(seen) - pdist(models[0]))


def choice(rows: np.ndarray) -> tuple[Timing, float]:
    """Time the choice of candidates, and return its index over the best of many starts."""

    def index(seed: int) -> float:
        chosen = rows[choose_by_exchange(rows, CHOSEN, np.random.default_rng(seed)).indices]
        return observability_o1(chosen.reshape(-1, rows.shape[2]), CHOSEN)

    best = max(index(seed) for seed in range(1, STARTS + 1))
    return timed(lambda: index(0)), index(0) / best


def processes(*, with_demo: bool) -> Iterator[tuple[str, Timing]]:
    """Time whole processes and what they are compared with."""
    with tempfile.TemporaryDirectory() as folder:
        write_campaign(campaign(100), Path(folder) / "campaign")
        command = _process("-m", "truepose")
        yield "truepose --help", timed(lambda: command("--help"), runs=9)
        for how in (("--json",), ()):
            yield (
                " ".join(("truepose identify, 100 rows,", *(how or ("as tables",)))),
                timed(lambda how=how: command("identify", f"{folder}/campaign", *how), runs=9),
            )
        yield "plain loop of 10^7 squares", timed(lambda: _process("-c", _LOOP)(), runs=3)
        if with_demo:
            yield "truepose demo", timed(lambda: command("demo", "--out", f"{folder}/demo"), runs=1)


def _process(*start: str):
    def run(*arguments: str) -> None:
        subprocess.run([sys.executable, *start, *arguments], check=True, capture_output=True)

    return run
