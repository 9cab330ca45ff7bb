"""What is counted of many outcomes, and how it stands beside its target."""

import json
import math

import pytest

from tests.studies.diagnosis_report import tallies
from tests.studies.diagnosis_report.document import report_document
from tests.studies.diagnosis_report.judging import Named, Outcome
from tests.studies.diagnosis_report.planted.nothing_hidden import everyday, false_alarms
from tests.studies.diagnosis_report.planted.pairs import pairs
from tests.studies.diagnosis_report.planted.single_effects import left_out, power
from tests.studies.diagnosis_report.rows import at_least, no_faults
from tests.studies.diagnosis_report.studies import studies
from tests.studies.diagnosis_report.study import Extent
from truepose.reports.table_report import Verdict

SMALL = Extent(campaigns=2, undisturbed=3, pairs=4, sizes=(50, 100, 200))


def outcome(**changes):
    values = {
        "verdict": "explained",
        "named": (Named(1.0, (0.5,)),),
        "found": ("joint_gain (joint 2)",),
        "wrong": (),
        "rivals": (),
        "depends_on": (),
        "structure_left": False,
        "only_likely": False,
        "mean_before_mm": 0.10,
        "mean_after_mm": 0.05,
        "label": "gain",
        "readings": 100,
        "seed": 1,
        "wall_s": 1.0,
    }
    return Outcome(**(values | changes))


def missed(**changes):
    return outcome(**({"verdict": "consistent", "named": (Named(0.0),), "found": ()} | changes))


def row(rows, part):
    (found,) = (one for one in rows if part in one.figure)
    return found


def test_names_count_among_the_detected_only_and_a_rival_is_half():
    outcomes = [outcome(), outcome(named=(Named(0.5),)), missed()]

    assert tallies.detected(outcomes) == pytest.approx(2 / 3)
    assert tallies.named(outcomes) == pytest.approx(0.75)


def test_a_wrong_name_with_a_rival_or_a_flag_is_not_sure():
    wrong = ("backlash (joint 3)",)
    outcomes = [
        outcome(wrong=wrong),
        outcome(wrong=wrong, rivals=("joint_gain (joint 2)",)),
        outcome(wrong=wrong, structure_left=True),
        outcome(),
    ]

    assert tallies.wrong_and_sure(outcomes) == 0.25


def test_the_interval_counts_every_amplitude_of_every_planted_effect():
    outcomes = [outcome(named=(Named(1.0, (0.5, -1.95)), Named(1.0, (1.97,)))), outcome(named=(Named(0.0),))]

    assert tallies.inside_interval(outcomes) == pytest.approx(2 / 3)


def test_shares_stand_by_size_and_a_dash_where_there_is_nothing_to_share():
    outcomes = [outcome(readings=200), missed(readings=50)]

    assert tallies.percent_by_size(outcomes, tallies.detected) == "0 / 100 %"
    assert tallies.percent_by_size(outcomes, tallies.named) == "- / 100 %"


def test_a_figure_without_campaigns_never_passes():
    assert at_least("detected", 0.8, [], tallies.detected).verdict is Verdict.NOT_MEASURED


def test_an_error_in_a_diagnosis_fails_and_is_quoted():
    said = no_faults([outcome(), outcome(verdict="", fault="KeyError: 'x'", seed=7)])

    assert said.verdict is Verdict.FAILED
    assert said.measured == "1; gain, 100 readings, seed 7: KeyError: 'x'"


def test_the_rows_of_a_table_share_no_cell():
    cells = {}
    for trial in power(SMALL).trials:
        cells.setdefault(trial.label, set()).add(trial.seed)

    assert len(set.union(*cells.values())) == sum(len(seeds) for seeds in cells.values())


def test_detection_is_judged_at_each_size_by_its_own_limit():
    study = power(SMALL)
    label = study.trials[0].label
    outcomes = [outcome(label=label, readings=50)] * 4 + [missed(label=label, readings=50)]
    outcomes += [outcome(label=label)] * 9 + [missed(label=label)]

    rows = study.rows(outcomes)

    assert row(rows, "detected at 50").verdict is Verdict.PASSED  # 80 % of 80 %
    assert row(rows, "detected at 100").verdict is Verdict.FAILED  # 90 % of 97 %


def test_swapped_labels_are_shown_and_not_judged():
    study = power(SMALL)
    (label,) = {trial.label for trial in study.trials if "swapped" in trial.label}
    good = [outcome(label=study.trials[0].label)] * 3

    rows = study.rows([*good, missed(label=label), missed(label=label)])

    assert row(rows, "detected at 100").measured == "100.0 %"
    assert row(rows, label).measured.startswith("detected 0 %")


def test_two_in_a_hundred_false_alarms_are_the_most():
    study = false_alarms(SMALL, heavy_tails=False)

    at_limit = study.rows([outcome()] * 2 + [missed()] * 98)
    beyond = study.rows([outcome()] * 3 + [missed()] * 97)

    assert row(at_limit, "false alarms").verdict is Verdict.PASSED
    assert row(beyond, "false alarms").verdict is Verdict.FAILED


def test_an_effect_left_out_is_left_out_of_the_library_of_its_own_trials():
    trials = left_out(SMALL).trials

    assert all(trial.without == (trial.planted[0].effect,) for trial in trials)


def test_pairs_meet_every_effect_and_no_pair_twice():
    study = pairs(Extent(pairs=36, sizes=(100,)))

    labels = [trial.label for trial in study.trials]
    assert len(labels) == len(set(labels))
    met = {effect.effect for trial in study.trials for effect in trial.planted}
    assert len(met) == 14  # of waves there are four cases, of gains two: 18 cases


def test_a_third_name_is_counted_at_its_size_and_alike_pairs_stand_apart():
    study = pairs(SMALL)
    alike, (first, *_) = study.trials[-1].label, (trial.label for trial in study.trials)
    good = outcome(label=first, named=(Named(1.0), Named(1.0)))

    rows = study.rows([good, outcome(label=first, wrong=("payload (tool)",)), missed(label=alike)])

    assert row(rows, "both named").measured == "100.0 %"
    assert row(rows, "no third at 100").measured == "50.0 %"
    assert row(rows, alike).verdict is Verdict.NO_TARGET


def test_the_everyday_ratio_is_the_mean_of_the_campaigns():
    study = everyday(SMALL)

    rows = study.rows([outcome(mean_after_mm=0.04), outcome(mean_after_mm=0.06)])

    assert row(rows, "100 readings").measured == "0.500"
    assert row(rows, "worst").measured == "0.600"


def test_every_trial_of_a_report_is_another_one():
    trials = [trial for study in studies(SMALL) for trial in study.trials]

    keys = [(trial.label, trial.without, trial.readings, trial.seed) for trial in trials]
    assert len(set(keys)) == len(keys)


def test_a_report_of_fewer_sizes_needs_no_other():
    for study in studies(Extent(campaigns=1, undisturbed=1, pairs=2, sizes=(100,))):
        study.rows([])

        assert {trial.readings for trial in study.trials} == {100}


def test_the_document_has_no_number_that_json_cannot_hold():
    rows = {"power": [outcome(wall_s=math.nan, mean_after_mm=math.inf)]}

    document = json.loads(json.dumps(report_document(SMALL, (), rows), allow_nan=False))

    assert document["outcomes"]["power"][0]["wall_s"] is None
    assert document["outcomes"]["power"][0]["named"] == [
        {"credit": 1.0, "scores": [0.5], "order_found": None}
    ]
