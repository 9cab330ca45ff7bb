"""What `--workers` says is understood, or refused in a sentence."""

import pytest

from truepose.analysis.parallel.addresses import WorkerAddress, worker_address
from truepose.domain.errors import ConfigurationError


def test_a_number_is_so_many_processes():
    assert worker_address("3") == WorkerAddress(processes=3)


@pytest.mark.parametrize(
    "where",
    [
        *("", "0", "-1", "1025", "many", "dask://", "dask://host", "dask://:8786"),
        *("dask://host:0", "dask://host:65536", "dask://host:port"),
        *("dask://a..b:8786", "dask://.host:8786", f"dask://{'a' * 64}:8786"),
    ],
)
def test_what_names_no_workers_is_refused_with_what_does(where):
    with pytest.raises(ConfigurationError, match="give a number of processes, `dask` for Dask"):
        worker_address(where)
