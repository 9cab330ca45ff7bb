"""A service with people of every role that is asked anything by each of them, and by nobody who is known."""

import asyncio
import contextlib
import random
from collections import Counter
from dataclasses import dataclass, field

from tests.helpers.web.any_requests import Drawing, answer_of
from tests.integration.web.bench import CELL, Bench
from tests.integration.web.calibration.test_jobs import FakeWorker
from tests.integration.web.listening import listening
from truepose.analysis.job_queue.accuracy_tasks import PromiseTask
from truepose.analysis.job_queue.tasks import IdentifyTask, ValidateTask
from truepose.app import create_app
from truepose.domain.errors import TrueposeError
from truepose.domain.people import OF_PROGRAMS, Role
from truepose.settings import Settings

NOBODY = "nobody"


class Worker(FakeWorker):
    """Answers at once; what it has no answer for is refused, as a task may be."""

    async def __call__(self, task, told):
        """Answer."""
        if isinstance(task, PromiseTask):
            return await asyncio.to_thread(task.perform, lambda fraction, doing: None)
        if isinstance(task, IdentifyTask | ValidateTask):
            return await super().__call__(task, told)
        raise TrueposeError("This is not computed here.")


@dataclass
class Outcome:
    """What many requests came to."""

    statuses: Counter = field(default_factory=Counter)
    failed: list = field(default_factory=list)  # role, request and answer of each 5xx and each reset

    def add(self, role, asked, answered):
        """Count a request."""
        self.statuses[answered.status] += 1
        if answered.status is None or answered.status >= 500:
            self.failed.append((role, asked, answered))


@contextlib.contextmanager
def asked_by_strangers(folder):
    """Serve people of every role; yields the port, and the headers that each of them sends."""
    (folder / "cell.toml").write_text(CELL)
    settings = Settings(database_url=f"sqlite:///{folder}/truepose.sqlite3", cell_file=folder / "cell.toml")
    secrets = asyncio.run(_entered(settings))
    with listening(create_app(settings, Bench().registry(), Worker())) as url:
        yield int(url.rpartition(":")[2]), secrets


async def _entered(settings):
    app = create_app(settings, Bench().registry())
    async with app.router.lifespan_context(app):
        accounts = app.state.context.people.accounts
        secrets = {NOBODY: []}
        for role in Role:
            of_person = Role.ADMINISTRATOR if role in OF_PROGRAMS else role
            person = await accounts.register.enter(f"{role} by name", of_person, "a test")
            _, token = await accounts.make_token(person, f"script of {role}", role, 30, "a test")
            secrets[role.value] = [f"authorization: Bearer {token}".encode()]
            if role not in OF_PROGRAMS:
                browser = await accounts.sign_ins.opened(person, "tablet")
                secrets[f"{role} at a tablet"] = [f"cookie: truepose_sign_in={browser.secret}".encode()]
    return secrets


def outcome_of(folder, count, seed):
    """Return what `count` requests came to, by every role in turn."""
    outcome, draw = Outcome(), random.Random(seed)
    with asked_by_strangers(folder) as (port, secrets):
        document = create_app(Settings()).openapi()
        drawing = Drawing(document, draw)
        roles = sorted(secrets)
        for k in range(count):
            role = roles[k % len(roles)]
            asked = drawing.request(secrets[role])
            outcome.add(role, asked, answer_of(port, asked.raw))
    return outcome
