"""One trial: an effect hidden in a campaign, the diagnosis of it, and the judgement."""

import json
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from tests.studies.diagnosis_report.errors import NothingHappenedError
from tests.studies.diagnosis_report.judging import Outcome, failed, judge
from tests.studies.diagnosis_report.planted.planting import Planted, scenario_text
from tests.studies.diagnosis_report.recorder import Recorder, running_recorder
from truepose.domain.campaign import Campaign
from truepose.domain.diagnosis import Diagnosis
from truepose.exchange.campaigns.folder import read_campaign
from truepose.kinematics.chain import forward, nominal_values

_MOST_CELLS: Final = 50  # of 50 readings one in five holds no bad reading of 3 %
_NEXT_CELL: Final = 100_000  # seeds of a trial's further cells; far above any seed that is asked for
_OTHER_NEST_MM: Final = 50.0  # nests lie 130 mm apart, the robot is 3 mm off
_BAD_MM: Final = 0.1  # noise and scatter are 0.027 mm: four times that are no noise


@dataclass(frozen=True, slots=True)
class Trial:
    """What is hidden where, and what the diagnosis may use."""

    label: str
    planted: tuple[Planted, ...]
    readings: int
    seed: int
    scenario: str = "irb120-tilted"
    start: tuple[str, ...] | None = None  # None: the default of the diagnosis
    without: tuple[str, ...] = ()  # effects left out of the library
    heavy_tails: bool = False
    over_time: bool = True
    validation: int = 300


Diagnose = Callable[[Campaign, Trial], Diagnosis]


def run_trials(trials: tuple[Trial, ...], diagnose: Diagnose) -> tuple[Outcome, ...]:
    """Run trials one after the other with a recorder of their own.

    Raises
    ------
    RecorderFailedError
        A campaign cannot be recorded.
    NothingHappenedError
        Chance hid nothing in any of a trial's cells.
    """
    with tempfile.TemporaryDirectory() as folder, running_recorder() as recorder:
        return tuple(_run(trial, recorder, Path(folder), diagnose) for trial in trials)


def _run(trial: Trial, recorder: Recorder, folder: Path, diagnose: Diagnose) -> Outcome:
    campaign, planted = record_trial(trial, recorder, folder)
    began_s = time.perf_counter()
    try:
        outcome = judge(diagnose(campaign, trial), planted)
    except Exception as error:  # one of thousands: the report says which failed instead of losing the others
        outcome = failed(f"{type(error).__name__}: {error}", planted)
    wall_s = time.perf_counter() - began_s
    return replace(outcome, label=trial.label, readings=trial.readings, seed=trial.seed, wall_s=wall_s)


def record_trial(trial: Trial, recorder: Recorder, folder: Path) -> tuple[Campaign, tuple[Planted, ...]]:
    """Record the first cell of the trial in which chance let everything planted happen.

    Returns the campaign and what is hidden in it, bad readings with the share that they truly have; raises
    RecorderFailedError or NothingHappenedError.
    """
    scenario, out = folder / "scenario.toml", folder / "campaign"
    text = scenario_text(
        trial.scenario, trial.planted, heavy_tails=trial.heavy_tails, over_time=trial.over_time
    )
    scenario.write_text(text, encoding="utf-8")
    sizes = ("--configurations", str(trial.readings), "--validation", str(trial.validation))
    for seed in _seeds(trial.seed):
        recorder.record(str(scenario), "--seed", str(seed), "--out", str(out), *sizes)
        campaign = read_campaign(out)
        shares = _shares_hit(campaign, out / "truth.json")
        if all(shares.get(effect.effect, 1.0) > 0.0 for effect in trial.planted):
            return campaign, tuple(_as_it_happened(effect, shares) for effect in trial.planted)
    raise NothingHappenedError(f"{trial.label}: none of {_MOST_CELLS} cells shows the effect; enlarge it.")


def _seeds(first: int) -> Iterator[int]:
    return iter(range(first, first + _MOST_CELLS * _NEXT_CELL, _NEXT_CELL))


def _shares_hit(campaign: Campaign, truth: Path) -> dict[str, float]:
    """Return which share of the calibration readings is bad, and which is of another nest than it says."""
    points = campaign.calibration
    if points is None:
        return {}
    true_mm = json.loads(truth.read_text(encoding="utf-8"))["true_positions_mm"]["calibration"]
    off_mm = np.linalg.norm(points.position_mm - np.array(true_mm), axis=1)
    centres = np.array([nest.centre_mm for nest in campaign.nests])
    chain = forward(nominal_values(campaign.robot, points.stops.joints_rad), np.eye(3), np.zeros(3))
    labelled = chain.points(centres[points.nest - 1])
    away_mm = np.linalg.norm(points.position_mm - labelled, axis=1)
    return {
        "outliers": float(np.mean(off_mm > _BAD_MM)),
        "label_swap": float(np.mean(away_mm > _OTHER_NEST_MM)),
    }


def _as_it_happened(planted: Planted, shares: dict[str, float]) -> Planted:
    """Return bad readings with the share that chance made of them, all else as it is."""
    if planted.effect != "outliers":
        return planted
    return replace(planted, right=dict.fromkeys(planted.right, shares["outliers"]))
