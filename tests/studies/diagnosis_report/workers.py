"""Trials on several cores, each core with its own recorder and its own diagnosis."""

import contextlib
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from itertools import groupby
from typing import Final

import numpy as np

from tests.studies.diagnosis_report.judging import Outcome
from tests.studies.diagnosis_report.trials import Trial, run_trials
from truepose.analysis.errors import PartFailedError
from truepose.analysis.parallel.tasks import Cluster, Part, PartAnswer, in_order
from truepose.demo.client import Told
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.campaign import Campaign
from truepose.domain.diagnosis import Diagnosis

# A campaign keeps one core busy; numpy's own threads on top of one process a core only get in the way.
_THREADS: Final = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

_TOGETHER: Final = 12  # trials for one start of a recorder, which takes as long as a diagnosis


@contextlib.contextmanager
def worker_processes(jobs: int) -> Iterator[Executor]:
    """Offer `jobs` processes of one core each while the context lasts."""
    before = dict(os.environ)
    os.environ |= dict.fromkeys(_THREADS, "1")  # read when a fresh process imports numpy
    try:
        with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as workers:
            yield workers
    finally:
        for name in _THREADS:
            os.environ.pop(name)
        os.environ |= {name: before[name] for name in _THREADS if name in before}


def outcomes_of(trials: Sequence[Trial], cluster: Cluster, told: Told) -> list[Outcome]:
    """Run the trials, those of one cell of the table together, and tell how many are done."""
    outcomes: list[Outcome] = []
    for done in in_order(cluster.outcomes(_run_cell, map(_part, _cells(trials)))):
        if not isinstance(done, PartAnswer):
            raise PartFailedError(f"{done.name}: {done.why}")
        outcomes += done.answer
        told(len(outcomes), len(trials), done.answer[0].label)
    return outcomes


def _part(cell: tuple[Trial, ...]) -> Part[tuple[Trial, ...]]:
    return Part(f"{cell[0].label}, {cell[0].readings} readings, from seed {cell[0].seed}", cell)


def _cells(trials: Sequence[Trial]) -> list[tuple[Trial, ...]]:
    """Split the trials where the cell changes, long cells more often, so that no core runs out early."""
    grouped = groupby(trials, key=lambda trial: (trial.label, trial.readings))
    cells = (tuple(group) for _, group in grouped)
    return [cell[at : at + _TOGETHER] for cell in cells for at in range(0, len(cell), _TOGETHER)]


def _run_cell(trials: tuple[Trial, ...], _seed: np.random.SeedSequence) -> tuple[Outcome, ...]:
    return run_trials(trials, _diagnose)


def _diagnose(campaign: Campaign, trial: Trial) -> Diagnosis:
    return diagnose(campaign, trial.start, without=trial.without)
