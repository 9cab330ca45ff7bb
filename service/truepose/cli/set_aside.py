"""Options that set readings aside: which, why and by whom. Heavy imports wait until a command runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.domain.campaign import Campaign, ReadingsSetAside

SetAside = Annotated[
    list[str] | None,
    typer.Option(
        "--set-aside",
        metavar="READING=REASON",
        help="Analyse without this reading; repeatable. A reading is a configuration (17), with its nest "
        "(17/2), or base point or target and nest (17/3/2).",
    ),
]
SetAsideFile = Annotated[
    Path | None,
    typer.Option(
        "--set-aside-file",
        metavar="FILE.csv",
        help="The same for many readings: columns config, nest, reason; base_point for lengths, target for "
        "contacts.",
    ),
]
Person = Annotated[
    str,
    typer.Option("--person", help="Who sets the readings aside (default: the name of this account)."),
]


def without_set_aside(
    campaign: "Campaign", readings: list[str] | None, file: Path | None, person: str
) -> "Campaign":
    """Return the campaign as the service analyses it without these readings; itself where none is named.

    Raises ConfigurationError, and InputFileError for the file.
    """
    from truepose.domain.set_aside import found_in, named_by_numbers, without_readings
    from truepose.exchange.tables.set_aside import read_set_aside_table, reading_and_reason

    wanted = [reading_and_reason(text) for text in readings or ()]
    wanted += [] if file is None else read_set_aside_table(file)
    if not wanted:
        return campaign
    named = named_by_numbers(campaign, wanted, " ".join(person.split()) or _account())
    return without_readings(campaign, found_in(campaign, named))


def _account() -> str:
    import getpass

    try:
        return getpass.getuser()
    except (ImportError, KeyError, OSError) as error:  # which of them depends on the system and on Python
        raise ConfigurationError(
            "This account has no name: say with --person who sets readings aside."
        ) from error


def set_aside_line(aside: "ReadingsSetAside | None", words: Catalogue) -> list[str]:
    """Return which readings were set aside, for a terminal; their number and reason stand in the message."""
    from truepose.domain.set_aside import listed

    return [] if aside is None else [words.say("terminal.set_aside", readings=listed(aside))]
