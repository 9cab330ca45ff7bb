"""What a service is started with; read by the composition root and the command line only."""

import ipaddress
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Literal

from truepose.storage.backup.plan import BackupPlan
from truepose.storage.engine.files import data_folder


class LogLevel(StrEnum):
    """Least weight of what is logged."""

    DEBUG = "debug"  # also what is asked every few seconds
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


def default_database_url() -> str:
    """Return the URL of the database in the user's data folder."""
    return f"sqlite:///{data_folder() / 'truepose.sqlite3'}"


@dataclass(frozen=True, slots=True)
class Settings:
    """Where the service stores, where it listens, and which cell it works with."""

    database_url: str = field(default_factory=default_database_url)
    host: str = "127.0.0.1"
    port: int = 8000  # 0: any free one
    cell_file: Path | None = None  # None: the simulated cell
    simulated_pace: Literal[0, 1] = 1  # wall time per cell time; 0: waiting costs nothing
    simulated_scenario: str = "irb120-tilted"  # without a cell file
    simulated_seed: int = 0
    simulated_faults: Path | None = None  # what goes wrong in the simulated cell, and when
    allowed_hosts: tuple[str, ...] = ()  # names beside loopback and `host` under which it may be asked
    proxies: tuple[str, ...] = ()  # addresses whose X-Forwarded-For says who asks
    backups: BackupPlan | None = None
    log_file: Path | None = None  # of JSON lines; None: beside the database
    log_level: LogLevel = LogLevel.INFO
    pin_secret: Path | None = None  # what PINs are mixed with; None: beside the database
    tls_certificate: Path | None = None  # PEM; with it the service speaks TLS itself
    tls_key: Path | None = None
    accounts: bool = True  # False: nobody is asked who they are; on loopback only

    @property
    def reached_from_here_alone(self) -> bool:
        """Whether only this computer reaches the service: on loopback, behind no proxy."""
        return not self.allowed_hosts and not self.proxies and _is_loopback(self.host)


@dataclass(frozen=True, slots=True)
class PlantSettings:
    """What a plant's service is started with, beside what every service is."""

    service: Settings
    cells_file: Path
    every_s: float = 30.0  # between two visits to a cell
    name: str = "plant"
    due_after_days: float = 30.0  # since its last measurement, until a robot is due; a quick check each month
    workers: str | None = (
        None  # who has campaigns tell what they do, as `--workers` says; None: a process here
    )


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"
