"""A service whose worker knows the answers: diagnoses without numerics."""

import contextlib
from dataclasses import replace

from tests.helpers.diagnosis.answers import make_diagnosis
from tests.helpers.web import clients
from tests.integration.web.conftest import asking
from truepose.analysis.job_queue.tasks import stored_campaign


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
    async with clients.served(settings, bench.registry(), worker) as client:
        yield client, asking(client)
