"""Workers of Dask that end before they are of any use, or come back late, and nobody who is left."""

import contextlib
import os
import threading

import dask
import pytest
from distributed import LocalCluster

from tests.helpers.parts import killed_at_first, waited_for
from truepose.analysis.errors import ClusterError
from truepose.analysis.parallel.dask_pool import of_scheduler, of_this_computer
from truepose.analysis.parallel.tasks import Cluster, Part, Task

ENDS_AT_FIRST = """
import os, pathlib

for mark in pathlib.Path({marks!r}).glob("*"):
    mark.unlink()
    os._exit(1)
"""


@pytest.fixture
def folder(tmp_path):
    """Return what makes a folder with so many marks."""

    def made(name, count):
        (tmp_path / name).mkdir()
        for number in range(count):
            (tmp_path / name / str(number)).touch()
        return str(tmp_path / name)

    return made


def test_a_worker_that_ends_while_it_starts_and_one_that_is_given_up_are_started_again(
    folder, tmp_path, monkeypatch
):
    monkeypatch.setattr("truepose.analysis.parallel.dask_pool._FETCHED_S", 0.5)
    preload = tmp_path / "ends_at_first.py"
    preload.write_text(ENDS_AT_FIRST.format(marks=folder("starts", 1)))
    given_up_at_once = {"distributed.deploy.lost-worker-timeout": "0 s"}

    settings = {"distributed.worker.preload": [str(preload)], **given_up_at_once}
    with dask.config.set(settings), of_this_computer(1) as places:
        answers = Cluster(places).answers(killed_at_first, [Part("unlucky", folder("parts", 1))])
        places.begin(Task(waited_for, 0, 7, 0.0))
        done = threading.Event()
        [(_, future)] = places._futures.values()
        future.add_done_callback(lambda _: done.set())
        assert done.wait(60.0)
        with contextlib.suppress(OSError):
            places.client.run(os._exit, 1)  # with an answer that nobody has fetched
        lost = places.ended()

    assert answers == ["at last"]
    assert lost[0] == 7
    assert lost[1].answer == 0.0


def test_where_no_worker_is_left_what_came_stands_and_a_sentence_says_what_to_do(monkeypatch):
    monkeypatch.setattr("truepose.analysis.parallel.dask_pool.LOOKED_S", 0.02)
    monkeypatch.setattr("truepose.analysis.parallel.dask_pool._WITHOUT_S", 0.1)
    one = LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp", dashboard_address=None
    )

    with one as cluster, of_scheduler(cluster.scheduler_address.removeprefix("tcp://")) as places:
        outcomes = Cluster(places).outcomes(held, [Part("soon", False), Part("held", True)])
        first = next(outcomes)
        cluster.scale(0)
        with pytest.raises(
            ClusterError, match=r"so far are kept\. To continue, start one \(dask worker tcp:"
        ):
            next(outcomes)
        HELD.set()

    assert first.answer == "soon"


HELD = threading.Event()  # of the worker, which is a thread of this process


def held(item, _seed):
    """Answer, an item that is to wait once the test is over."""
    if item:
        HELD.wait(60.0)
    return "soon"
