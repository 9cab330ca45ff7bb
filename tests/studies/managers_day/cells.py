"""A cell as those know it who keep it running: its files, its service, its backups, its disk."""

import contextlib
import shutil
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import httpx

from tests.helpers.ports import free_port
from tests.studies.managers_day.cable import Cable
from tests.studies.managers_day.programs import Running, answered, truepose
from truepose.demo.client import PERSON, ServiceClient
from truepose.demo.errors import SessionHaltedError

ADMINISTRATOR: Final = "Ada Byron"
_CALIBRATION: Final = 15  # configurations
_VALIDATION: Final = 12
_LEGS: Final = 4  # poses of the ballbar
LIMIT_MM: Final = 0.1
STRICT_MM: Final = 0.02  # that no robot holds
_ANSWER_S: Final = 120.0
_CELL: Final = """name = "{name}"
robot = "abb-irb-120"
robot_serial_number = "SIM-{seed}"

[simulated]
scenario = "irb120-tilted"
seed = {seed}
pace = 0
"""


@dataclass(frozen=True, slots=True)
class Measured:
    """What somebody made of a robot."""

    campaign: int
    passed: bool
    mean_mm: float

    @property
    def told(self) -> str:
        """In words."""
        return f"mean error {1000 * self.mean_mm:.0f} um, validation {'passed' if self.passed else 'failed'}"


@dataclass(slots=True)
class CellAtWork:
    """A cell, its service and its cable to the plant; backups lie on another disk than its records."""

    name: str
    folder: Path
    seed: int  # of the simulated robot, which is its serial number as well
    port: int = field(default_factory=free_port)
    backups_kept: int = 7
    token: str = ""  # of the tablet
    token_of_viewer: str = ""  # of the manager, who looks at its pages
    service: Running | None = None
    cable: Cable = field(init=False)

    def __post_init__(self) -> None:
        self.cable = Cable(free_port(), self.port)
        self.disk.mkdir(parents=True)
        self.backups.mkdir()

    @property
    def disk(self) -> Path:
        """Where its records are."""
        return self.folder / "disk"

    @property
    def backups(self) -> Path:
        """Where its scheduled backups are."""
        return self.folder / "backups"

    @property
    def database(self) -> Path:
        """Its records."""
        return self.disk / "cell.db"

    @property
    def url_of_database(self) -> str:
        """Its records, as commands are told."""
        return f"sqlite:///{self.database}"

    @property
    def robot(self) -> str:
        """Serial number of its robot."""
        return f"SIM-{self.seed}"

    async def set_up(self, plants_token: Path) -> None:
        """Enter people, and make the tokens of the tablet and of the plant."""
        here = ("--database", self.url_of_database)
        await truepose("people", "add", ADMINISTRATOR, "--role", "administrator", *here)
        await truepose("people", "add", PERSON, "--role", "operator", *here)
        tablet = ("people", "token", PERSON, "--name", "tablet", "--role", "operator")
        self.token = (await answered(*tablet, *here))["secret"]
        looks = ("people", "token", ADMINISTRATOR, "--name", "office", "--role", "viewer")
        self.token_of_viewer = (await answered(*looks, *here))["secret"]
        plant = ("people", "token", ADMINISTRATOR, "--name", "plant north", "--role", "plant")
        plants_token.touch(mode=0o600)
        plants_token.write_text(await truepose(*plant, "--days", "365", *here), encoding="utf-8")

    async def start(self) -> None:
        """Start its service with a simulated cell, and a backup whenever one is due."""
        file = self.folder / "cell.toml"
        file.write_text(_CELL.format(name=self.name, seed=self.seed), encoding="utf-8")
        serve = ("serve", "--cell", str(file), "--database", self.url_of_database, "--port", str(self.port))
        backup = ("--backup-to", str(self.backups), "--backup-every", "1m")
        keep = ("--backup-keep", str(self.backups_kept))
        self.service, _ = await Running.serving(
            *serve, *backup, *keep, log=self.folder / "service.log", folder=self.folder
        )

    async def stop(self) -> None:
        """End its service as somebody does who means it."""
        if self.service is not None:
            await self.service.ask_to_end()
            self.service = None

    async def lose_disk(self) -> None:
        """Have its disk fail under the running service, and its computer go off."""
        assert self.service is not None
        for file in self.disk.glob("cell.db*"):
            file.unlink()
        await self.service.kill()
        self.service = None
        shutil.rmtree(self.disk)

    @contextlib.asynccontextmanager
    async def at_the_tablet(self) -> AsyncIterator[ServiceClient]:
        """Somebody stands at the cell."""
        async with self._asked() as http:
            yield ServiceClient(http)

    async def post(self, path: str, body: dict[str, Any]) -> Any:
        """Have something done at the cell."""
        async with self._asked() as http:
            answer = await http.post(f"/api/v1{path}", json=body)
            assert answer.is_success, answer.text
            return answer.json()

    @contextlib.asynccontextmanager
    async def _asked(self) -> AsyncIterator[httpx.AsyncClient]:
        headers = {"Authorization": f"Bearer {self.token}"}
        url = f"http://127.0.0.1:{self.port}"
        async with httpx.AsyncClient(
            base_url=url, headers=headers, timeout=_ANSWER_S, trust_env=False
        ) as http:
            yield http


async def measure_by_tracker(
    client: ServiceClient, name: str, seed: int, limit_mm: float = LIMIT_MM
) -> Measured:
    """Calibrate and validate a robot by the tracker."""
    await client.connect_devices()
    plan = await client.plan(f"{name}, calibration", "calibration", _CALIBRATION, seed)
    return await measure_as_planned(client, name, await client.finish_job(plan), seed, limit_mm)


async def measure_as_planned(
    client: ServiceClient, name: str, calibration: int, seed: int, limit_mm: float = LIMIT_MM
) -> Measured:
    """Run a calibration that is planned, identify, and validate what comes of it."""
    plan = await client.plan(f"{name}, validation", "validation", _VALIDATION, seed)
    validation = await client.finish_job(plan)
    for session in (calibration, validation):
        await client.run_session(session, lambda *_: None)
    campaign = await client.make_campaign(name, calibration, validation)
    number = await client.finish_job(await client.identify(campaign))
    model = (await client.get(f"/identifications/{number}"))["model_id"]
    number = await client.finish_job(await client.validate(model, campaign, limit_mm))
    judged = (await client.get(f"/validations/{number}"))["document"]
    return Measured(campaign, judged["pass"], judged["position"]["identified"]["mean_mm"])


async def verdict_on(client: ServiceClient, campaign: int) -> str:
    """Have a campaign diagnosed and return what is said of the robot."""
    number = await client.finish_job(await client.diagnose(campaign))
    verdict: str = (await client.get(f"/diagnoses/{number}"))["document"]["verdict"]
    return verdict


async def measure_by_ballbar(client: ServiceClient, name: str, seed: int) -> int:
    """Measure some poses with the ballbar; the number of the campaign."""
    session = await client.plan_ballbar(name, _LEGS, seed)
    ended = await client.person_at(session).walk()
    if ended["state"] != "finished":
        raise SessionHaltedError(f"Session {session} is {ended['state']}: {ended['reason']}")
    return await client.campaign_of(name, [session])


def newest(backups: Path) -> Path | None:
    """Return the newest backup of a schedule."""
    made: Sequence[Path] = sorted(backups.glob("truepose-*.sqlite3"))
    return made[-1] if made else None
