"""Commands that start something (a service, a simulated cell, demo, night run) or help who runs it."""

import os
import re
import sys
from pathlib import Path
from typing import Annotated, Final

import typer

from truepose.cli.output import print_lines, remark
from truepose.settings import LogLevel
from truepose.storage.backup.plan import BackupPlan

_SECONDS: Final = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}
_FORM: Final = re.compile(r"(\d+(?:\.\d+)?)([smhd]?)")


def seconds(text: str) -> float:
    """Return a duration [s]; raises BadParameter."""
    found = _FORM.fullmatch(str(text).strip().lower())
    if found is None or float(found[1]) == 0:
        raise typer.BadParameter(f"'{text}' is not a duration; write 90s, 30m, 24h or 7d.")
    return float(found[1]) * _SECONDS[found[2]]


BackupTo = Annotated[
    Path | None, typer.Option(help="Folder for copies of the database, made while the service runs.")
]
BackupEvery = Annotated[
    float, typer.Option(parser=seconds, help="Time between two copies.", metavar="90s|30m|24h|7d")
]
BackupKeep = Annotated[int, typer.Option(min=1, help="Number of newest copies to keep.")]
A_DAY_S = 24 * 3600.0
A_WEEK = 7  # copies


def wanted_copies(folder: Path | None, every_s: float, keep: int) -> BackupPlan | None:
    """Return what copies the options ask for."""
    return None if folder is None else BackupPlan(folder, every_s, keep)


TlsCertificate = Annotated[
    Path | None, typer.Option(help="PEM file of a certificate: the service speaks TLS itself.")
]
TlsKey = Annotated[Path | None, typer.Option(help="PEM file of its key.")]
Accounts = Annotated[
    bool,
    typer.Option(
        "--accounts/--no-accounts", help="Require sign-in; without it, only this computer has access."
    ),
]
LogFile = Annotated[
    Path | None, typer.Option(help="Log file (JSON lines, up to 48 MB; default: beside the database).")
]
LeastLogged = Annotated[LogLevel, typer.Option(help="Lowest level that is logged.", case_sensitive=False)]
PinSecret = Annotated[
    Path | None,
    typer.Option(help="File with the secret for PIN hashes (default: beside the database)."),
]
Host = Annotated[str, typer.Option(help="Address to listen on.")]
Port = Annotated[int, typer.Option(min=0, max=65535, help="Port to listen on; 0 picks a free port.")]
Seed = Annotated[int, typer.Option(min=0, help="Same seed, same simulated cell.")]
Faults = Annotated[
    Path | None, typer.Option(help="Faults of the simulated cell and their times (TOML, docs/faults.md).")
]


def demo_command(
    out: Annotated[Path, typer.Option(help="Folder for result.json and the reports.")] = Path(
        "truepose-demo"
    ),
    seed: Seed = 0,
    scenario: Annotated[str, typer.Option(help="Shipped scenario, or a scenario file.")] = "irb120-tilted",
) -> int:
    """Measure, identify, validate and diagnose a simulated robot through real drivers and the REST API.

    Example: truepose demo --out demo --seed 3
    """
    from truepose.demo.command import run_demo

    status = run_demo(out, seed, scenario)
    if status in {0, 1}:
        _print_reports(out)
    return status


def _print_reports(out: Path) -> None:
    from truepose.demo.report import print_reports
    from truepose.reports.paper import NoPdfError

    try:
        print_reports(out)
    except NoPdfError as error:
        remark([str(error)])  # the pages are there


def nightly_command(
    out: Annotated[
        Path,
        typer.Option(help="Folder for reports, and for history.jsonl, to which each nightly run is added."),
    ] = Path("truepose-nightly"),
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the draws (default: the date).")] = None,
    case: Annotated[
        list[str] | None, typer.Option(help="Run only this case; may be repeated. Not added to the history.")
    ] = None,
    bench: Annotated[
        list[str] | None,
        typer.Option(help="MODULE:NAME of a driver's bench, or of a list of them; may be repeated."),
    ] = None,
    label: Annotated[str, typer.Option(help="Label by which to find the run, such as a commit.")] = "",
) -> int:
    """Run every unattended test on simulated devices, and compare with earlier nightly runs.

    Example: truepose nightly --out nightly
    """
    from truepose.night.check import NightRequest, seed_of_the_day
    from truepose.night.nightly import run_nightly

    drawn = seed_of_the_day() if seed is None else seed
    return run_nightly(NightRequest(out, drawn, label, tuple(case or ()), tuple(bench or ())))


def serve_command(
    cell: Annotated[Path | None, typer.Option(help="Cell file (TOML; default: the simulated cell).")] = None,
    database: Annotated[
        str | None,
        typer.Option(help="URL of its records: sqlite:///cell.db, or postgresql://user@host/name."),
    ] = None,
    host: Host = "127.0.0.1",
    port: Port = 8000,
    allowed_host: Annotated[
        list[str] | None,
        typer.Option(
            envvar="TRUEPOSE_ALLOWED_HOSTS",
            help="Name or address under which the service may be called, besides localhost and --host; "
            "https://NAME behind a proxy with TLS. May be repeated.",
        ),
    ] = None,
    behind_proxy: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ADDRESS",
            help="Address or network of a trusted proxy, whose X-Forwarded-For names the client. "
            "May be repeated.",
        ),
    ] = None,
    tls_certificate: TlsCertificate = None,
    tls_key: TlsKey = None,
    accounts: Accounts = True,
    faults: Faults = None,
    backup_to: BackupTo = None,
    backup_every: BackupEvery = A_DAY_S,
    backup_keep: BackupKeep = A_WEEK,
    log_file: LogFile = None,
    log_level: LeastLogged = LogLevel.INFO,
    pin_secret: PinSecret = None,
) -> int:
    """Run the service; prints one JSON line with its url when ready.

    Example: truepose serve --cell cell.toml --database sqlite:///cell.db --port 8000
    """
    from truepose.app import serve
    from truepose.settings import Settings, default_database_url

    return serve(
        Settings(
            database_url=database or default_database_url(),
            host=host,
            port=port,
            allowed_hosts=tuple(allowed_host or ()),
            proxies=tuple(behind_proxy or ()),
            cell_file=cell,
            simulated_faults=faults,
            backups=wanted_copies(backup_to, backup_every, backup_keep),
            log_file=log_file,
            log_level=log_level,
            pin_secret=pin_secret,
            tls_certificate=tls_certificate,
            tls_key=tls_key,
            accounts=accounts,
        )
    )


def simulate_command(
    scenario: Annotated[str, typer.Argument(help="Shipped scenario, or a scenario file.")] = "irb120-tilted",
    seed: Seed = 0,
    port_base: Annotated[int, typer.Option(min=0, max=65535, help="First port; 0 picks free ones.")] = 0,
    pace: Annotated[int, typer.Option(min=0, max=1, help="1: real time; 0: no waiting.")] = 1,
    host: Host = "127.0.0.1",
    model: Annotated[
        Path | None,
        typer.Option(help="Identified model (JSON): its robot, base and tool replace the scenario's."),
    ] = None,
    state: Annotated[
        Path | None,
        typer.Option(help="File that keeps the state of the cell, to resume from it."),
    ] = None,
    faults: Faults = None,
) -> int:
    """Start only the simulated instruments and robot; prints one JSON line per endpoint.

    Example: truepose simulate irb120-clean --seed 3 --port-base 7000 --pace 0
    Example: truepose simulate --model robot.json
    """
    arguments = ["--seed", seed, "--port-base", port_base, "--pace", pace, "--host", host]
    arguments += [] if model is None else ["--model", model]
    arguments += [] if state is None else ["--state", state]
    arguments += [] if faults is None else ["--faults", faults]
    command = [
        sys.executable,
        "-m",
        "truepose_simulators",
        scenario,
        *(str(argument) for argument in arguments),
    ]
    # In our place, not beside us: whoever signals this process ends the cell, and no child is left behind.
    os.execv(sys.executable, command)


def plant_command(
    cells: Annotated[Path, typer.Option(help="Cells file (TOML): name, address, token and certificate.")],
    database: Annotated[
        str, typer.Option(help="URL of its own records: sqlite:///plant.db, or postgresql://user@host/name.")
    ],
    host: Host = "127.0.0.1",
    port: Port = 8100,
    every: Annotated[
        float,
        typer.Option(parser=seconds, help="Time between two queries of a cell.", metavar="30s|10m|1h"),
    ] = 30.0,
    due_after: Annotated[
        float,
        typer.Option(
            parser=seconds,
            help="Time after its last measurement until a robot is due; by type in the cells file.",
            metavar="14d|30d|90d",
        ),
    ] = 30 * A_DAY_S,
    name: Annotated[str, typer.Option(help="Name of the plant.")] = "plant",
    allowed_host: Annotated[
        list[str] | None,
        typer.Option(
            help="Name or address under which the service may be called, besides localhost and --host."
        ),
    ] = None,
    behind_proxy: Annotated[
        list[str] | None, typer.Option(metavar="ADDRESS", help="Address or network of a trusted proxy.")
    ] = None,
    tls_certificate: TlsCertificate = None,
    tls_key: TlsKey = None,
    accounts: Accounts = True,
    workers: Annotated[
        str | None,
        typer.Option(
            metavar="NUMBER|dask|dask://HOST:PORT",
            help="Number of processes that compare robots, or Dask workers (default: one process).",
        ),
    ] = None,
    backup_to: BackupTo = None,
    backup_every: BackupEvery = A_DAY_S,
    backup_keep: BackupKeep = A_WEEK,
    log_file: LogFile = None,
    log_level: LeastLogged = LogLevel.INFO,
    pin_secret: PinSecret = None,
) -> int:
    """Collect results from many cells, and send them plans and models; prints one JSON line with its URL.

    Example: truepose plant --cells cells.toml --database sqlite:///plant.db --port 8100
    """
    from truepose.analysis.parallel.addresses import worker_address
    from truepose.app.plants import serve_plant
    from truepose.settings import PlantSettings, Settings

    if workers is not None:
        worker_address(workers)
    service = Settings(
        database_url=database,
        host=host,
        port=port,
        allowed_hosts=tuple(allowed_host or ()),
        proxies=tuple(behind_proxy or ()),
        backups=wanted_copies(backup_to, backup_every, backup_keep),
        log_file=log_file,
        log_level=log_level,
        pin_secret=pin_secret,
        tls_certificate=tls_certificate,
        tls_key=tls_key,
        accounts=accounts,
    )
    return serve_plant(PlantSettings(service, cells, every, name, due_after / A_DAY_S, workers))


def unit_command() -> int:
    """Print the systemd unit of the service.

    Example: truepose unit | sudo tee /etc/systemd/system/truepose.service
    """
    return _print_shipped("truepose.service")


def dashboard_command() -> int:
    """Print a Grafana dashboard for the metrics at /metrics.

    Example: truepose dashboard > truepose.json
    """
    return _print_shipped("dashboard.json")


def _print_shipped(name: str) -> int:
    from importlib.resources import files

    text = files("truepose").joinpath("app", "deployment", name).read_text(encoding="utf-8")
    print_lines(text.splitlines())
    return 0
