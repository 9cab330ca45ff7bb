"""A service whose worker knows the answers: diagnoses without numerics."""

import contextlib
from dataclasses import replace

import httpx

from tests.helpers.diagnosis.answers import make_diagnosis
from tests.integration.web.conftest import asking
from truepose.analysis.workers.tasks import stored_campaign
from truepose.app import create_app


class Diagnostician:
    """Answers with the next of its diagnoses, for the robot that it was given."""

    def __init__(self):
        self.found = []
        self.tasks = []

    async def __call__(self, task, told):
        self.tasks.append(task)
        await told(0.5, "screening 21 causes")
        robot = stored_campaign(task.campaign).robot.name
        return replace(self.found.pop(0) if self.found else make_diagnosis(), robot=robot)


@contextlib.asynccontextmanager
async def served(settings, bench, worker):
    application = create_app(settings, bench.registry(), worker)
    transport = httpx.ASGITransport(application)
    async with (
        application.router.lifespan_context(application),
        httpx.AsyncClient(transport=transport, base_url="http://service") as client,
    ):
        yield client, asking(client)
