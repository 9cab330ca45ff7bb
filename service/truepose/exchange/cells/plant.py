"""Cells files of a plant: TOML, one [[cell]] each, described in docs/plant.md with an example."""

import ipaddress
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final
from urllib.parse import SplitResult, urlsplit

from truepose.exchange.document import TEXT, Form, Key, Node, read_bytes, read_keys, toml_document


@dataclass(frozen=True, slots=True)
class PlantCell:
    """How a plant reaches one of its cells."""

    name: str
    url: str
    token_file: Path | None = None  # None: the cell asks nobody who they are
    certificate: Path | None = None  # PEM that the cell shows, or of who signed it; None: of a public one


@dataclass(frozen=True, slots=True)
class PlantFile:
    """What the cells file of a plant says."""

    cells: tuple[PlantCell, ...]
    due_after_days: Mapping[str, float] = field(default_factory=dict)  # by type of robot, as cells name it


def _read_url(node: Node) -> str:
    text = node.text().rstrip("/")
    parts = _parts(text)
    if parts is None or parts.scheme not in {"http", "https"} or not _is_place(text, parts):
        node.fail(
            "write the address as http:// or https://, host name and optional port, such as "
            "https://cell-3.plant:8443"
        )
    return text


def _parts(text: str) -> SplitResult | None:
    """Return the parts of an address; None: it is none, or its port is no port."""
    try:
        parts = urlsplit(text)
        return None if parts.port == 0 else parts
    except ValueError:
        return None


def _is_place(text: str, parts: SplitResult) -> bool:
    """Whether an address has a host and perhaps a port, and nothing else: pages and sentences show it."""
    return bool(parts.hostname) and not parts.path and not any(sign in text for sign in "?#@")


def _stays_secret(url: str) -> bool:
    """Whether what is sent to an address is read there alone: over TLS, or to this very computer."""
    parts = urlsplit(url)
    return parts.scheme == "https" or _is_loopback(parts.hostname or "")


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


_DUE: Final = "due_after_days"
_FILE: Final = Form(lambda node: Path(node.text()))
_CELL: Final = [
    Key("name", "name", TEXT),
    Key("url", "url", Form(_read_url)),
    Key("token_file", "token_file", _FILE, absent=None),
    Key("certificate", "certificate", _FILE, absent=None),
]


def read_plant_file(path: Path) -> PlantFile:
    """Read the cells file of a plant; files that it names are looked for beside it.

    Raises
    ------
    InputFileError
        With file and key, and line where the text is not TOML at all.
    """
    root = toml_document(path.name, read_bytes(path))
    for entry in root.unlisted(["cell", _DUE]):
        entry.fail(f"unknown key; cells are [[cell]] entries, days of robot types in [{_DUE}]")
    cells: dict[str, PlantCell] = {}
    for node in root.key("cell").items():
        cell = _read_cell(node, path.parent)
        if cell.name in cells:
            node.key("name").fail(f"two cells are called {cell.name!r}; names must differ")
        twin = next((one.name for one in cells.values() if one.url == cell.url), None)
        if twin is not None:
            node.key("url").fail(
                f"{twin!r} has the same address; remove one entry, or the cell is collected twice"
            )
        cells[cell.name] = cell
    return PlantFile(tuple(cells.values()), _read_due(root.optional(_DUE)))


def _read_due(node: Node | None) -> dict[str, float]:
    return {} if node is None else {robot: node.key(robot).number(above=0.0) for robot in node.entries()}


def _read_cell(node: Node, folder: Path) -> PlantCell:
    for entry in node.unlisted([key.name for key in _CELL]):
        entry.fail("unknown key; a cell has name, url, token_file and certificate")
    cell = PlantCell(**read_keys(node, _CELL))
    if cell.token_file is not None and not _stays_secret(cell.url):
        node.key("token_file").fail(
            "a token is sent over https:// only, or to this computer: over http:// anyone on the "
            "network could read it"
        )
    token, certificate = (
        None if file is None else folder / file for file in (cell.token_file, cell.certificate)
    )
    return replace(cell, token_file=token, certificate=certificate)
