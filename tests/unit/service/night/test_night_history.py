"""What nights are compared with: which night was the first bad one, and what is unusual."""

import json
from datetime import UTC, datetime, timedelta

import pytest

from truepose.domain.errors import TrueposeError
from truepose.night.check import Check, NightRequest
from truepose.night.errors import UnknownCaseError, UnreadableHistoryError
from truepose.night.history import (
    COMPARED_NIGHTS,
    HISTORY,
    Night,
    NightFigure,
    append_night,
    course,
    read_history,
)
from truepose.night.nightly import run_nightly

FIRST = datetime(2026, 11, 1, 2, 17, tzinfo=UTC)
KEY = ("cell", "error")


def night(number, value=0.02, passed=True):
    figure = NightFigure(case=KEY[0], figure=KEY[1], passed=passed, value=value)
    began = FIRST + timedelta(days=number)
    return Night(began=began, version="0.1.0", label="", seed=number, figures=(figure,))


def nights(passed):
    return [night(number, passed=one) for number, one in enumerate(passed)]


@pytest.mark.parametrize(
    ("passed", "first"),
    [
        ([True, True, True], None),
        ([True, True, False], 2),
        ([True, False, False, False], 1),
        ([False, True, False, False], 2),  # an older failure that was mended is none of tonight's
        ([False, False, True], None),
        ([False], 0),
    ],
)
def test_the_first_bad_night_is_the_first_of_those_in_a_row(passed, first):
    every = nights(passed)

    assert course(every, *KEY).first_bad is (None if first is None else every[first])


def test_a_night_that_did_not_have_the_figure_is_neither_good_nor_bad():
    every = nights([True, False, False, False])
    every[2] = every[2].model_copy(update={"figures": ()})

    assert course(every, *KEY).first_bad is every[1]


def test_a_figure_far_from_what_it_was_is_unusual_even_where_its_limit_holds():
    usual = [night(n, value=0.020 + 0.001 * (n % 3)) for n in range(10)]

    assert course([*usual, night(10, value=0.030)], *KEY).unusual
    assert not course([*usual, night(10, value=0.0225)], *KEY).unusual


def test_where_every_night_was_the_same_a_rounding_is_nothing():
    same = [night(n, value=0.02) for n in range(10)]

    assert not course([*same, night(10, value=0.02001)], *KEY).unusual
    assert course([*same, night(10, value=0.0215)], *KEY).unusual


def test_of_too_few_nights_nothing_is_usual():
    assert not course([*[night(n) for n in range(4)], night(4, value=1.0)], *KEY).unusual


def test_only_the_last_thirty_nights_are_compared():
    every = nights([False] * 40)

    assert course(every, *KEY).first_bad is every[40 - COMPARED_NIGHTS - 1]


def test_what_was_written_is_read_again(tmp_path):
    for one in nights([True, False]):
        append_night(tmp_path / HISTORY, one)

    assert read_history(tmp_path / HISTORY) == nights([True, False])


def test_a_night_that_was_cut_off_while_it_was_written_is_left_out_and_written_over(tmp_path):
    file = tmp_path / HISTORY
    append_night(file, night(0))
    whole = file.read_bytes()
    file.write_bytes(whole + whole[:20])

    assert read_history(file) == [night(0)]
    append_night(file, night(1))
    assert read_history(file) == [night(0), night(1)]


def test_a_file_that_is_no_history_is_named_with_its_line_before_anything_runs(tmp_path):
    (tmp_path / HISTORY).write_text("not a night\n", encoding="utf-8")

    with pytest.raises(UnreadableHistoryError, match=r"history\.jsonl, line 1.*Move the file away"):
        run_nightly(NightRequest(tmp_path, 1), [Told([])])


class Told:
    """A case that gives what it is told, or fails."""

    note = "nothing is tried"

    def __init__(self, checks, name="cell"):
        self.name = name
        self._checks = checks

    def run(self, folder, progress):
        if isinstance(self._checks, Exception):
            raise self._checks
        return self._checks


GOOD = Check("error", "<= 0.1 mm", "0.02 mm", passed=True, value=0.02)
BAD = Check("error", "<= 0.1 mm", "0.30 mm", passed=False, value=0.30)


def test_a_night_names_the_first_bad_one_in_every_place_where_people_look(tmp_path, capsys):
    for seed, check in enumerate((GOOD, GOOD, BAD, BAD)):
        run_nightly(NightRequest(tmp_path, seed, label=f"commit-{seed}"), [Told([check])])

    printed = capsys.readouterr().out
    for said in (printed, (tmp_path / "report.html").read_text(), (tmp_path / "result.json").read_text()):
        assert "commit-2)" in said
        assert "truepose nightly --seed 3 --case cell --out night-again" in said
    assert "--seed 3 --case cell" in (tmp_path / "junit.xml").read_text()
    assert "0.30 mm; target: &lt;= 0.1 mm" in (tmp_path / "junit.xml").read_text()
    assert json.loads((tmp_path / "result.json").read_text())["pass"] is False


def test_what_became_of_a_case_is_said_as_soon_as_it_is_known(tmp_path, capsys):
    cases = [Told([GOOD]), Told([GOOD, BAD], name="second"), Told(TrueposeError("no link"), name="third")]

    run_nightly(NightRequest(tmp_path, 1), cases)

    said = capsys.readouterr().err
    for line in ("cell: passed (0 s)", "second: missed error (0 s)", "third: no link (0 s)"):
        assert line in said


def test_a_good_night_names_none(tmp_path, capsys):
    for seed in range(3):
        assert run_nightly(NightRequest(tmp_path, seed), [Told([GOOD])]) == 0

    assert "failing since the night" not in capsys.readouterr().out
    assert "--case" not in (tmp_path / "report.html").read_text()
    assert len(read_history(tmp_path / HISTORY)) == 3


def test_a_single_case_is_run_alone_and_is_no_night(tmp_path):
    failing = Told(TrueposeError("would fail"), name="other")

    assert run_nightly(NightRequest(tmp_path, 1, only=("cell",)), [Told([GOOD]), failing]) == 0
    assert read_history(tmp_path / HISTORY) == []


def test_a_case_that_does_not_exist_is_refused_with_those_that_do(tmp_path):
    with pytest.raises(UnknownCaseError, match='Unknown case "sell"; available cases: cell'):
        run_nightly(NightRequest(tmp_path, 1, only=("sell",)), [Told([GOOD])])


def test_a_case_that_could_not_run_is_a_bad_night_too(tmp_path):
    run_nightly(NightRequest(tmp_path, 1), [Told([GOOD])])
    assert run_nightly(NightRequest(tmp_path, 2), [Told(TrueposeError("no link"))]) == 3

    last = read_history(tmp_path / HISTORY)[-1]
    assert [one.passed for one in last.figures] == [False]
    assert "no link" in (tmp_path / "report.html").read_text()
