"""Fixtures: campaigns with something hidden in them, and what the diagnosis says of each."""

import pytest

from tests.studies.diagnosis_report.judging import judge
from tests.studies.diagnosis_report.recorder import running_recorder
from tests.studies.diagnosis_report.trials import record_trial
from truepose.diagnosis.diagnose import diagnose


@pytest.fixture(scope="session")
def recorder():
    """One process that records campaigns of simulated cells."""
    with running_recorder() as running:
        yield running


@pytest.fixture
def diagnosed(recorder, tmp_path):
    """Return the diagnosis of a trial, and the outcome: the same beside what was hidden."""

    def run(trial):
        campaign, planted = record_trial(trial, recorder, tmp_path)
        diagnosis = diagnose(campaign, trial.start, without=trial.without)
        return diagnosis, judge(diagnosis, planted)

    return run
