"""On the way down corrections go, and the chain of what stays is whole."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.integration.storage.migration.test_migration_of_models import ask, migrate
from tests.integration.web.calibration.stored_models import store_model
from truepose.domain.results.corrections import CorrectedTargets, CorrectionTotals, FileCorrection
from truepose.storage.calibration.campaigns import CampaignRepository
from truepose.storage.calibration.corrections import CorrectionRepository, NewCorrection
from truepose.storage.calibration.jobs import JobRepository
from truepose.storage.calibration.results import ResultRepository
from truepose.storage.columns import pack
from truepose.storage.database import Database
from truepose.storage.integrity.verification import verify
from truepose.storage.records import JobKind, RequestKey

_TOTALS = CorrectionTotals({"ok": 1}, (), *(0.0,) * 3, 0, 0.0, 0, 0.0, 0.0, zone_known=True)
_TARGETS = CorrectedTargets(
    ("p1",), ("ok",), np.ones(1, dtype=np.int64), *(np.zeros((1, 3)),) * 2, *(np.zeros(1),) * 3
)


async def _with_a_model(database):
    jobs, results = JobRepository(database), ResultRepository(database)
    here = SimpleNamespace(campaigns=CampaignRepository(database), jobs=jobs, results=results)
    return await store_model(here)


@pytest.fixture
async def file(tmp_path):
    """A database with a model, and a correction by it."""
    file = tmp_path / "truepose.sqlite3"
    database = Database(f"sqlite:///{file}")
    model, jobs = await _with_a_model(database), JobRepository(database)
    made = NewCorrection("m.mod", "a", "b", {}, FileCorrection(_TOTALS, 0.1, (), 0, ()), pack(_TARGETS), b"x")
    job = await jobs.add(JobKind.CORRECTION, {}, RequestKey("k", "f"))
    await CorrectionRepository(database).keep(job, model, made)
    await jobs.add(JobKind.VALIDATION, {})  # behind it, and stays
    database.close()
    return file


async def test_what_stays_is_as_it_was_and_verified(file):
    assert verify(file).findings == ()

    migrate(file, "0010", up=False)

    assert ask(file, "SELECT id, kind FROM jobs ORDER BY id") == [(1, "identification"), (3, "validation")]
    assert ask(file, "SELECT record FROM links WHERE record = 'corrections'") == []
    assert ask(file, "SELECT * FROM request_keys") == []
    migrate(file, "head", up=True)
    assert verify(file).findings == ()


async def test_without_any_the_chain_stays_as_it_is(tmp_path):
    file = tmp_path / "truepose.sqlite3"
    database = Database(f"sqlite:///{file}")
    await _with_a_model(database)
    database.close()
    before = ask(file, "SELECT * FROM links")

    migrate(file, "0010", up=False)

    assert ask(file, "SELECT * FROM links") == before != []


async def test_there_is_a_way_further_down(file):
    migrate(file, "0009", up=False)
    migrate(file, "head", up=True)

    assert ask(file, "SELECT count(*) FROM models") == [(1,)]
    assert verify(file).findings == ()
