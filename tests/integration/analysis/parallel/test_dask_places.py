"""Workers on Dask: the same bits as processes of this computer, and nobody who would compute others."""

import dataclasses
import sys

import dask
import pytest

from tests.helpers.parts import odd_is_refused, sums_of_noise, waited_for
from truepose.analysis.errors import ClusterError, WorkersUnlikeError
from truepose.analysis.parallel.arithmetic import arithmetic
from truepose.analysis.parallel.dask_pool import DaskPlaces, of_scheduler, of_this_computer
from truepose.analysis.parallel.local_pool import Processes, workers
from truepose.analysis.parallel.tasks import Cluster, Part, PartAnswer, PartFailure, Task, in_order
from truepose.domain.errors import ConfigurationError


@pytest.fixture(scope="module")
def places():
    """Two workers in processes of their own, as a plant has them."""
    with of_this_computer(2) as places:
        yield places


@pytest.fixture
def cluster(places):
    return Cluster(places)


def _parts(items):
    return [Part(f"part {item}", item) for item in items]


def test_dask_gives_the_bits_of_this_process(cluster):
    sizes = [40, 3, 25, 60, 8, 41, 17]

    here = [Task(sums_of_noise, 7, number, size).perform().answer for number, size in enumerate(sizes)]

    assert cluster.answers(sums_of_noise, _parts(sizes), seed=7) == here


def test_more_parts_than_dask_is_given_at_a_time_all_come_back(cluster):
    outcomes = list(in_order(cluster.outcomes(odd_is_refused, _parts(range(0, 80, 2)))))

    assert [outcome.answer for outcome in outcomes] == list(range(40))


def test_what_fails_is_named_and_the_others_go_on(cluster):
    outcomes = list(in_order(cluster.outcomes(odd_is_refused, _parts([2, 3, 4]))))

    assert [type(outcome) for outcome in outcomes] == [PartAnswer, PartFailure, PartAnswer]
    assert (outcomes[1].name, outcomes[1].why) == ("part 3", "3 cannot be halved.")


def test_a_work_that_is_given_up_leaves_the_workers_to_the_next(cluster):
    outcomes = cluster.outcomes(waited_for, _parts([0.0, 0.05, 0.05, 0.05, 0.05]))
    next(outcomes)
    outcomes.close()

    assert cluster.answers(waited_for, _parts([0.0, 0.01])) == [0.0, 0.01]


def test_what_a_scheduler_drops_ends_the_run_with_a_sentence_and_what_came_before_stands(places, cluster):
    outcomes = cluster.outcomes(waited_for, _parts([0.0, 0.5, 0.51, 0.52]))
    first = next(outcomes)

    places.client.cancel([future for _, future in places._futures.values()], force=True)

    assert first.answer == 0.0
    with pytest.raises(ClusterError, match="results so far are kept"):
        list(outcomes)
    assert cluster.answers(waited_for, _parts([0.0])) == [0.0]


@pytest.mark.parametrize("name", ["truepose", "numpy", "scipy", "python"])
def test_a_worker_of_another_version_is_refused_by_name(name):
    own = arithmetic()

    assert own.unlike(own) == ""
    assert f"{name} 9.9, but this program has" in own.unlike(dataclasses.replace(own, **{name: "9.9"}))


def test_a_worker_whose_processor_rounds_otherwise_is_refused():
    own = arithmetic()

    assert "rounds differently" in own.unlike(dataclasses.replace(own, sample="0" * 16))
    assert "OMP_NUM_THREADS=1" in own.unlike(dataclasses.replace(own, threads="4"))


def test_a_run_with_such_a_worker_ends_with_a_sentence(places, monkeypatch):
    other = dataclasses.replace(arithmetic(), numpy="1.26.4", threads="1")
    monkeypatch.setattr("truepose.analysis.parallel.dask_pool.as_one_thread", lambda _: other)

    with pytest.raises(WorkersUnlikeError, match="Worker tcp://127"):
        DaskPlaces(places.client, "start one")


def test_a_worker_that_joins_later_and_differs_ends_the_run(places, monkeypatch):
    monkeypatch.setattr(places, "_alike", dataclasses.replace(arithmetic(), numpy="1.26.4", threads="1"))

    with pytest.raises(WorkersUnlikeError, match=r"has numpy .*, but this program has 1\.26\.4"):
        Cluster(places).answers(sums_of_noise, _parts([3]))


def test_a_scheduler_is_found_at_its_address(places):
    address = places.client.scheduler.address.removeprefix("tcp://")

    with workers(f"dask://{address}", parts=2) as cluster:
        assert cluster.answers(waited_for, _parts([0.0, 0.01])) == [0.0, 0.01]


def test_where_no_scheduler_answers_it_says_so(monkeypatch, unused_tcp_port):
    monkeypatch.setattr("truepose.analysis.parallel.dask_pool._PATIENCE_S", 0.2)

    with (
        pytest.raises(ClusterError, match=f"No Dask scheduler answers at tcp://127.0.0.1:{unused_tcp_port}"),
        of_scheduler(f"127.0.0.1:{unused_tcp_port}"),
    ):
        pass


def test_tls_without_a_certificate_of_ones_own_is_a_sentence():
    asked = {"distributed.comm.require-encryption": True}

    with (
        dask.config.set(asked),
        pytest.raises(ClusterError, match="names no certificate for this command"),
        of_scheduler("127.0.0.1:1"),
    ):
        pass


def test_without_dask_one_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)

    with pytest.raises(ConfigurationError, match=r"pip install 'truepose\[dask\]'"), workers("dask", parts=2):
        pass


def test_few_parts_are_given_to_processes_of_this_computer():
    with workers(None, parts=2) as cluster:
        assert isinstance(cluster._places, Processes)
        assert isinstance(next(cluster.outcomes(waited_for, _parts([0.0]))), PartAnswer | PartFailure)
