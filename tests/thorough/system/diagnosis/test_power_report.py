"""The power report: trials recorded, diagnosed in other processes, counted and written."""

import json
import os
from dataclasses import replace

import numpy as np
import pytest

from tests.studies.diagnosis_report.__main__ import main
from tests.studies.diagnosis_report.errors import NothingHappenedError, RecorderFailedError
from tests.studies.diagnosis_report.planted.cases import FOR_INFORMATION, REALISTIC
from tests.studies.diagnosis_report.study import trial_of
from tests.studies.diagnosis_report.trials import Trial, record_trial, run_trials
from tests.studies.diagnosis_report.workers import outcomes_of
from truepose.analysis.parallel.local_pool import workers


def bad_readings(seed, size=50):
    (case,) = (one for one in REALISTIC if "readings off" in one.label)
    return trial_of((case,), size, seed)


def test_bad_readings_are_counted_as_they_truly_are_and_never_none(recorder, tmp_path):
    shares = []
    for seed in range(1, 9):  # of 50 readings one campaign in five has none at 3 %
        _, (hidden,) = record_trial(bad_readings(seed), recorder, tmp_path)
        shares += hidden.right.values()

    readings = 50 * np.array(shares)
    assert readings == pytest.approx(readings.round())
    assert readings.min() >= 1
    assert len(set(readings)) > 1


def test_swapped_labels_hit_at_least_one_reading(recorder, tmp_path):
    campaign, _ = record_trial(trial_of(FOR_INFORMATION, 50, 4), recorder, tmp_path)

    assert len(campaign.calibration) == 50


def test_an_effect_that_hits_nothing_is_said(recorder, tmp_path):
    (hidden,) = bad_readings(1).planted
    none = Trial("no bad readings", (replace(hidden, amplitude=0.0),), 10, 1, validation=0)

    with pytest.raises(NothingHappenedError, match="none of 50 cells shows the effect"):
        record_trial(none, recorder, tmp_path)


def test_a_scenario_that_cannot_be_is_refused(recorder, tmp_path):
    with pytest.raises(RecorderFailedError, match="refused"):
        record_trial(Trial("nowhere", (), 10, 1, scenario="irb6600"), recorder, tmp_path)


def test_the_recorder_goes_on_after_a_refusal(recorder, tmp_path):
    with pytest.raises(RecorderFailedError):
        record_trial(Trial("nowhere", (), 10, 1, scenario="irb6600"), recorder, tmp_path)

    campaign, _ = record_trial(Trial("nothing", (), 10, 1), recorder, tmp_path)

    assert len(campaign.calibration) == 10


def test_a_diagnosis_that_fails_is_one_outcome_among_the_others():
    def fails(campaign, trial):
        raise ZeroDivisionError("division by zero")

    (outcome,) = run_trials((Trial("nothing", (), 10, 3, validation=0),), fails)

    assert (outcome.fault, outcome.seed) == ("ZeroDivisionError: division by zero", 3)
    assert not outcome.detected


def test_workers_leave_the_environment_as_it_was_and_tell_what_is_done():
    before, told = dict(os.environ), []
    trials = [Trial("nothing", (), size, 1, validation=20) for size in (20, 25)]

    with workers("1", len(trials)) as cluster:
        outcomes = outcomes_of(trials, cluster, lambda *said: told.append(said))

    assert dict(os.environ) == before
    assert [one.readings for one in outcomes] == [20, 25]
    assert [one.fault for one in outcomes] == ["", ""]
    assert told == [(1, 2, "nothing"), (2, 2, "nothing")]


def test_the_report_is_printed_and_written(tmp_path, capsys):
    arguments = ["--sections", "barely-visible", "--campaigns", "1", "--sizes", "50", "--workers", "1"]

    status = main([*arguments, "--out", str(tmp_path)])

    document = json.loads((tmp_path / "report.json").read_text())
    assert status == 0  # nothing in it has a target but the errors
    assert len(document["outcomes"]["barely-visible"]) == 4
    (section,) = document["sections"]
    assert section["rows"][-1]["measured"] == "0"
    said = capsys.readouterr().out
    assert all(row["figure"] in said for row in section["rows"])
    assert "links bend" in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--campaigns", "0"], "0 is not 1 or more"),
        (["--sizes", "50,many"], "a number of readings"),
        (["--sections", "powder"], "powder"),
    ],
)
def test_what_cannot_be_measured_is_refused_at_once(arguments, sentence, capsys):
    with pytest.raises(SystemExit) as refusal:
        main(arguments)

    assert refusal.value.code == 2
    assert sentence in capsys.readouterr().err
