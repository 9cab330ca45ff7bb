"""What correcting targets is worth: simulated robots sent to targets where no one measured them.

`python -m tests.studies.correction --seeds 10` records a campaign of each everyday robot (no drift, no
warm-up), diagnoses it, corrects targets drawn over the work space, and asks the simulated cell, whose
physics goes another route, where the tool truly is with and without the correction.
"""

import sys
from dataclasses import dataclass
from typing import Final

import numpy as np

from tests.studies.running import study_options
from tests.studies.simulated_arms import of_nest, read_back, true_nests_mm
from truepose.correction import Goals, correct
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.campaign import Campaign, Stops
from truepose.domain.identification import Model
from truepose.identification import identify
from truepose.identification.model.estimates import nominal_estimate
from truepose.identification.model.evaluation import Targets, evaluate
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording.campaign import record
from truepose_simulators.recording.plan import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario

_TARGETS: Final = 1000
_AFTER_S: Final = 3600.0  # when they are approached; nothing drifts in these cells
_NORMAL_95: Final = 1.959964


@dataclass(frozen=True, slots=True)
class Proof:
    """True errors of one robot at the targets, shape (n,) but for the components (n, 3) [mm]."""

    before_mm: np.ndarray
    after_mm: np.ndarray
    components_mm: np.ndarray
    uncertainty_mm: np.ndarray
    solved: int

    @property
    def coverage(self) -> float:
        """Share of components within 1.96 of the stated standard uncertainty."""
        return float(np.mean(np.abs(self.components_mm) <= _NORMAL_95 * self.uncertainty_mm[:, None]))


def main() -> int:
    """Print a line per robot and the medians."""
    options = study_options(
        __doc__,
        scenario="irb120-everyday",
        seeds=10,
        first_seed=1,
        configurations=300,
        plain=(False, "identify only, no diagnosis"),
    )
    proofs = []
    for seed in range(options.first_seed, options.first_seed + options.seeds):
        proofs.append(proof_of(options.scenario, seed, options.configurations, plain=options.plain))
        _print(f"seed {seed}", proofs[-1:])
    _print("all", proofs)
    return 0


def proof_of(scenario: str, seed: int, configurations: int, *, plain: bool) -> Proof:
    """Measure, identify and correct one robot, and look where it truly goes."""
    recording = record(load_scenario(scenario).quiet(), seed, RecordingRequest(configurations, 0))
    return _proof(recording.cell, _model(read_back(recording), plain=plain), seed)


def _model(campaign: Campaign, *, plain: bool) -> Model:
    found = identify(campaign).model if plain else diagnose(campaign).model
    if found is None:
        raise SystemExit("no model")
    return found


def _proof(cell: Cell, model: Model, seed: int) -> Proof:
    """Send a tool nest to where the nominal robot would have it, without and with correction."""
    joints = _drawn(model, seed)
    n, rows = len(joints), np.arange(len(joints))
    ways = {"direction": np.ones_like(joints, dtype=np.int64), "time_s": np.full(n, _AFTER_S)}
    ways |= {"attachment": np.ones(n, dtype=np.int64), "temperature_c": np.full(n, 23.0)}
    stops, nest = Stops(rows, joints, **ways), 1 + rows % len(model.nests)
    nominal = nominal_estimate(model)
    wanted = evaluate(nominal.structure, nominal.values, Targets(stops, nest))
    goals = Goals(stops, nest, wanted.unscaled_mm, wanted.chain.end_rotation)
    found = correct(model, goals)
    off = _true_mm(cell, found.joints_rad, nest) - wanted.unscaled_mm
    before = _true_mm(cell, joints, nest) - wanted.unscaled_mm
    ok = found.solved
    norms = (np.linalg.norm(errors[ok], axis=1) for errors in (before, off))
    return Proof(*norms, off[ok], found.uncertainty_mm[ok], int(ok.sum()))


def _drawn(model: Model, seed: int) -> np.ndarray:
    if model.zone is None:
        raise SystemExit("the model does not say where it was measured")
    low, high = np.array([(span.lower_rad, span.upper_rad) for span in model.zone.joint_ranges]).T
    return np.random.default_rng((seed, 7)).uniform(low, high, (_TARGETS, len(low)))


def _true_mm(cell: Cell, joints_rad: np.ndarray, nest: np.ndarray) -> np.ndarray:
    return of_nest(true_nests_mm(cell, joints_rad, _AFTER_S), nest)


def _print(name: str, proofs: list[Proof]) -> None:
    before, after = (np.concatenate([getattr(p, key) for p in proofs]) for key in ("before_mm", "after_mm"))
    coverage = np.mean([proof.coverage for proof in proofs])
    solved = sum(proof.solved for proof in proofs)
    sys.stdout.write(
        f"{name:8s} {solved:6d} targets: mean {before.mean():.3f} -> {after.mean():.4f} mm "
        f"({before.mean() / after.mean():.1f} x), max {before.max():.3f} -> {after.max():.3f}; "
        f"within stated 95 %: {100 * coverage:.1f} %\n"
    )
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
