"""What a night says of a driver on bad lines."""

import pytest

from tests.contract.devices.every import BENCHES
from truepose.demo.progress import progress_bar
from truepose.night.bad_lines import BadLine, _of_answers, _of_codec, _of_link, bad_lines
from truepose.night.errors import UnknownCaseError
from truepose_drivers.contract.codec_fuzz import CodecTally
from truepose_drivers.contract.hostile import Tally
from truepose_drivers.contract.link_recovery import RecoveryTally

EVERY = "tests.contract.devices.every:BENCHES"


def test_a_driver_that_keeps_the_contract_passes_and_leaves_no_example(tmp_path):
    (counter,) = [bench for bench in BENCHES if bench.plugin.name == "heidenhain_nd"]

    with progress_bar() as progress:
        checks = BadLine("heidenhain_nd", counter, seed=3, inputs=300, to_codec=300).run(tmp_path, progress)

    assert [check.figure for check in checks if not check.passed] == []
    assert (tmp_path / "examples.txt").read_text().strip() == ""


def test_a_codec_that_stumbles_is_a_figure_with_its_count_and_the_bytes():
    tally = CodecTally("acme")
    for _ in range(2):
        tally.note(b"4.4.4", ValueError("no number"))

    (wrong,) = _of_codec(tally)

    assert (wrong.passed, wrong.value) == (False, 2.0)
    assert "4.4.4" in wrong.measured


@pytest.mark.parametrize("harm", ["wrong_betrayable", "foreign", "hung", "out_of_step"])
def test_each_harm_is_a_figure_of_its_own_with_its_count_and_an_example(harm):
    tally = Tally("acme")
    for _ in range(3):
        tally.note(harm, "cut", "7.0 mm")

    (wrong,) = [check for check in _of_answers(tally) if not check.passed]

    assert wrong.value == 3.0
    assert "7.0 mm" in wrong.measured


@pytest.mark.parametrize(
    ("figure", "seen"),
    [
        ("longest time to report a lost link", {"lost_s": [0.1, 2.4]}),
        ("longest time to recover", {"back_s": [5.2]}),
        ("stale values accepted", {"stale": 1}),
        ("links left open", {"left_open": 2}),
    ],
)
def test_each_fault_of_a_link_that_is_not_kept_is_a_figure_of_its_own(figure, seen):
    assert [check.figure for check in _of_link(RecoveryTally("acme", **seen), 2.0) if not check.passed] == [
        figure
    ]


def test_every_bench_that_is_named_has_its_case_and_a_wrong_name_is_one_sentence():
    names = [case.name for case in bad_lines(1, (EVERY,))]

    assert "bad-line-leica-emscon" in names
    assert len(names) == len(BENCHES)
    with pytest.raises(UnknownCaseError, match="cannot be found"):
        bad_lines(1, ("tests.nowhere:BENCHES",))
