"""The OpenAPI document is true: whatever a client generates from it, the service answers as documented."""

import asyncio

import pytest
import schemathesis
from hypothesis import HealthCheck, settings
from schemathesis.specs.openapi.checks import positive_data_acceptance

from service.app import create_app
from service.settings import Settings
from tests.integration.web.bench import CELL, Bench
from tests.integration.web.listening import listening


async def never_done(task, told):
    await asyncio.sleep(3600)


@pytest.fixture(scope="module")
def api(tmp_path_factory):
    folder = tmp_path_factory.mktemp("service")
    (folder / "cell.toml").write_text(CELL)
    where = Settings(database_url=f"sqlite:///{folder}/truepose.sqlite3", cell_file=folder / "cell.toml")
    with listening(create_app(where, Bench().registry(), never_done)) as url:
        yield schemathesis.openapi.from_url(f"{url}/openapi.json")


# The stream of events does not end by itself; `test_events.py` is about it.
operations = schemathesis.pytest.from_fixture("api").exclude(path="/api/v1/events")


@operations.parametrize()
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
def test_every_operation_answers_as_documented(case):
    # Bytes that are a campaign cannot be told from other bytes by a schema.
    is_upload = (case.method, case.path) == ("POST", "/api/v1/campaigns")

    case.call_and_validate(excluded_checks=[positive_data_acceptance] if is_upload else [], timeout=10)
