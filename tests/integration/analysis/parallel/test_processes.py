"""Processes of this computer: lost, replaced, given up, never mixed up."""

import contextlib
import os
import select
import selectors

import pytest

from tests.helpers.parts import (
    cannot_travel,
    killed_at_first,
    odd_is_refused,
    process_of,
    sums_of_noise,
    waited_for,
)
from truepose.analysis.errors import PartFailedError
from truepose.analysis.parallel.local_pool import Processes
from truepose.analysis.parallel.tasks import Cluster, Part, PartAnswer, PartFailure, Task, in_order, seed_of


@pytest.fixture(scope="module")
def two():
    with Processes(2) as places:
        yield Cluster(places)


def _parts(items):
    return [Part(f"part {item}", item) for item in items]


def test_one_and_two_processes_and_none_give_the_same_bits(two):
    sizes = [40, 3, 25, 60, 8, 41, 17]
    here = [Task(sums_of_noise, 7, number, size).perform().answer for number, size in enumerate(sizes)]

    with Processes(1) as places:
        of_one = Cluster(places).answers(sums_of_noise, _parts(sizes), seed=7)
    of_two = two.answers(sums_of_noise, _parts(sizes), seed=7)

    assert of_one == here
    assert of_two == here


def test_a_part_draws_by_its_number_and_the_seed(two):
    same_size = _parts([5, 5])

    first, second = two.answers(sums_of_noise, same_size, seed=1)
    other, _ = two.answers(sums_of_noise, same_size, seed=2)

    assert len({first, second, other}) == 3
    assert [seed_of(9, number).entropy for number in range(2)] == [9, 9]
    assert seed_of(9, 3).spawn_key == (3,)


def test_what_is_short_comes_before_what_is_long_and_order_is_kept_where_asked(two):
    waits = _parts([0.4, 0.0, 0.0, 0.0])

    numbers = [outcome.number for outcome in two.outcomes(waited_for, waits)]
    ordered = [outcome.number for outcome in in_order(two.outcomes(waited_for, waits))]

    assert sorted(numbers) == [0, 1, 2, 3]
    assert numbers[0] != 0
    assert ordered == [0, 1, 2, 3]


def test_what_fails_is_named_and_the_others_go_on(two):
    outcomes = list(in_order(two.outcomes(odd_is_refused, _parts([2, 3, 4, 5]))))

    assert [type(outcome) for outcome in outcomes] == [PartAnswer, PartFailure, PartAnswer, PartFailure]
    assert (outcomes[1].name, outcomes[1].why, outcomes[1].code) == (
        "part 3",
        "3 cannot be halved.",
        "TP-1023",
    )
    assert "ZeroDivisionError: 5" in outcomes[3].why


def test_an_answer_that_cannot_travel_is_a_failure_of_its_part(two):
    (outcome,) = two.outcomes(cannot_travel, _parts([1]))

    assert "The program failed on this part" in outcome.why


def test_answers_of_which_one_is_missing_are_none(two):
    with pytest.raises(PartFailedError, match=r"part 3: 3 cannot be halved\."):
        two.answers(odd_is_refused, _parts([2, 3]))


def test_a_task_that_loses_its_process_goes_to_another_until_it_is_given_up(tmp_path):
    parts = []
    for name, marks in (("deadly", 9), ("unlucky", 1), ("fine", 0), ("as well", 0)):
        (tmp_path / name).mkdir()
        for mark in range(marks):
            (tmp_path / name / str(mark)).touch()
        parts.append(Part(name, str(tmp_path / name)))

    with Processes(1, allowed_failures=1) as places:
        outcomes = list(in_order(Cluster(places).outcomes(killed_at_first, parts)))

    assert [outcome.name for outcome in outcomes if isinstance(outcome, PartFailure)] == ["deadly"]
    assert "lost 2 times" in outcomes[0].why
    assert [outcome.answer for outcome in outcomes[1:]] == ["at last"] * 3


def test_processes_compute_with_one_thread_and_are_no_more_than_were_asked_for(two):
    found = two.answers(process_of, _parts(range(20)))

    assert {threads for _, threads in found} == {"1"}
    assert 1 <= len({process for process, _ in found} - {os.getpid()}) <= 2


def test_a_work_that_nobody_waits_for_ends_its_processes_and_the_next_one_begins_afresh():
    with Processes(2) as places:
        cluster = Cluster(places)
        outcomes = cluster.outcomes(waited_for, _parts([0.0, 600.0, 600.0]))
        next(outcomes)
        under_way = places.process_ids
        outcomes.close()

        assert [pid for pid in under_way if _lives(pid)] == []
        assert cluster.answers(waited_for, _parts([0.0])) == [0.0]


def test_parts_are_read_no_further_ahead_than_is_needed(two):
    read = []

    def parts():
        for number in range(50):
            read.append(number)
            yield Part(str(number), 0.0)

    outcomes = two.outcomes(waited_for, parts())
    next(outcomes)

    assert len(read) <= 5
    outcomes.close()


def test_no_pipe_is_selected_which_windows_cannot(monkeypatch):
    for name in ("select", "poll", "epoll"):
        monkeypatch.delattr(select, name, raising=False)
    monkeypatch.setattr(selectors, "DefaultSelector", None)

    with Processes(2) as places:
        assert Cluster(places).answers(waited_for, _parts([0.0, 0.0, 0.0])) == [0.0, 0.0, 0.0]


def test_no_parts_are_no_work(two):
    assert list(two.outcomes(waited_for, [])) == []


def _lives(pid):
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, 0)
        return True
    return False
