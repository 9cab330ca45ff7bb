"""Drawn requests of every operation, answered as documented; `make interface-report` draws more."""

import asyncio
import contextlib
from http.cookiejar import DefaultCookiePolicy

import pytest
import requests
import schemathesis
from hypothesis import HealthCheck, given, settings
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode
from schemathesis.specs.openapi.checks import positive_data_acceptance

from tests.integration.web.bench import CELL, Bench
from tests.integration.web.listening import listening
from tests.integration.web.middleware.test_openapi import OPERATIONS
from truepose.analysis.job_queue.accuracy_tasks import PromiseTask
from truepose.app import create_app
from truepose.settings import Settings

UPLOADS = {("post", "/api/v1/campaigns"), ("post", "/api/v1/models/{id}/corrections")}
ENOUGH = 6  # of each kind, each operation, each run


async def never_done(task, told):
    if isinstance(task, PromiseTask):  # is waited for
        return await asyncio.to_thread(task.perform, lambda fraction, doing: None)
    return await asyncio.sleep(3600)


@pytest.fixture(scope="module")
def api(tmp_path_factory):
    folder = tmp_path_factory.mktemp("service")
    (folder / "cell.toml").write_text(CELL)
    where = Settings(database_url=f"sqlite:///{folder}/truepose.sqlite3", cell_file=folder / "cell.toml")
    with listening(create_app(where, Bench().registry(), never_done)) as url:
        yield schemathesis.openapi.from_url(f"{url}/openapi.json", timeout=60)  # a second on an idle machine


@pytest.fixture(scope="module")
def connection():
    """One for all requests: to connect anew takes as long as most answers."""
    with requests.Session() as session:
        session.trust_env = False
        session.cookies.set_policy(DefaultCookiePolicy(allowed_domains=[]))
        yield session


def assert_answered_as_documented(operation, mode, connection):
    # That bytes are a campaign or a program is more than a schema can say.
    upload = (operation.method, operation.path) in UPLOADS

    @settings(max_examples=ENOUGH, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(case=operation.as_strategy(generation_mode=mode))
    def answers(case):
        unchecked = [positive_data_acceptance] if upload else []
        case.call_and_validate(excluded_checks=unchecked, timeout=60, session=connection)

    answers()


@pytest.mark.parametrize("mode", [GenerationMode.POSITIVE, GenerationMode.NEGATIVE])
@pytest.mark.parametrize(("method", "path"), OPERATIONS)
def test_what_is_drawn_is_answered_as_documented(api, connection, method, path, mode):
    with contextlib.suppress(Unsatisfiable):  # nothing can be wrong about a request without parameters
        assert_answered_as_documented(api[path][method], mode, connection)
