"""The command that starts a plant's service."""

from pathlib import Path
from typing import Annotated

import typer

from truepose.cli.administration.durations import seconds
from truepose.cli.copies import A_DAY_S, A_WEEK, BackupEvery, BackupKeep, BackupTo, wanted_copies
from truepose.settings import LogLevel

_DAY_S = 86400.0


def plant_command(
    cells: Annotated[Path, typer.Option(help="Cells file (TOML): name, address, token and certificate.")],
    database: Annotated[
        str, typer.Option(help="URL of its own records: sqlite:///plant.db, or postgresql://user@host/name.")
    ],
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="0 picks a free one.")] = 8100,
    every: Annotated[
        float, typer.Option(parser=seconds, help="Time between two visits to a cell.", metavar="30s|10m|1h")
    ] = 30.0,
    due_after: Annotated[
        float,
        typer.Option(
            parser=seconds,
            help="Time after its last measurement until a robot is due; per type in the cells file.",
            metavar="14d|30d|90d",
        ),
    ] = 30 * _DAY_S,
    name: Annotated[str, typer.Option(help="What the plant is called.")] = "plant",
    allowed_host: Annotated[
        list[str] | None,
        typer.Option(help="Name or address under which it may be asked, beside localhost and --host."),
    ] = None,
    behind_proxy: Annotated[
        list[str] | None, typer.Option(metavar="ADDRESS", help="Address or network that a proxy asks from.")
    ] = None,
    tls_certificate: Annotated[
        Path | None, typer.Option(help="PEM file of a certificate: the service speaks TLS itself.")
    ] = None,
    tls_key: Annotated[Path | None, typer.Option(help="PEM file of its key.")] = None,
    accounts: Annotated[
        bool, typer.Option("--accounts/--no-accounts", help="Ask who somebody is; without, on loopback only.")
    ] = True,
    workers: Annotated[
        str | None,
        typer.Option(
            metavar="NUMBER|dask|dask://HOST:PORT",
            help="Who compares robots: so many processes, or workers of Dask; else one process.",
        ),
    ] = None,
    backup_to: BackupTo = None,
    backup_every: BackupEvery = A_DAY_S,
    backup_keep: BackupKeep = A_WEEK,
    log_file: Annotated[
        Path | None, typer.Option(help="Log of JSON lines, 48 MB at most; by default beside the database.")
    ] = None,
    log_level: Annotated[
        LogLevel, typer.Option(help="Least weight of what is logged.", case_sensitive=False)
    ] = LogLevel.INFO,
    pin_secret: Annotated[
        Path | None,
        typer.Option(help="File of the secret that PINs are mixed with; by default beside the database."),
    ] = None,
) -> int:
    """Collect from many cells and hand plans and models down; prints one JSON line with its url when ready.

    Example: truepose plant --cells cells.toml --database sqlite:///plant.db --port 8100
    """
    from truepose.analysis.cluster.named import named
    from truepose.app.plants import serve_plant
    from truepose.settings import PlantSettings, Settings

    if workers is not None:
        named(workers)
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
    return serve_plant(PlantSettings(service, cells, every, name, due_after / _DAY_S, workers))
