"""A folder in which other software leaves what was measured: what there is to take, once it is whole.

Campaign folders and zips are taken as they are; a list of points `NAME.txt` with its joints
`NAME.joints.csv`, where `import.toml` in the folder states the rest.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.domain.measurement.campaign import Campaign
from truepose.exchange.campaigns.folder import DESCRIPTION
from truepose.exchange.campaigns.path import read_campaign_at
from truepose.exchange.point_lists.importing import STATED, import_points, read_stated

_LISTS: Final = frozenset({".txt", ".asc", ".pts", ".csv"})
_JOINTS: Final = ".joints.csv"


@dataclass(frozen=True, slots=True)
class Arrival:
    """Something that lies in the folder; another state of it is another arrival."""

    name: str
    files: tuple[Path, ...]
    states: tuple[tuple[int, int], ...]  # size and time of change [ns] of each

    def read(self) -> Campaign:
        """Return the campaign; raises InputFileError, UnknownRobotError."""
        first, *rest = self.files
        if not rest:
            return read_campaign_at(first)
        return import_points(first, rest[0], read_stated(first.parent / STATED))[0]


def arrivals(folder: Path) -> Iterator[Arrival]:
    """Yield what lies in a folder, by name; what vanishes meanwhile is passed over."""
    for path in sorted(folder.iterdir()):
        try:
            yield from _arrived(path)
        except FileNotFoundError:
            continue


def _arrived(path: Path) -> Iterator[Arrival]:
    joints = path.with_name(path.stem + _JOINTS)
    if path.is_dir() and (path / DESCRIPTION).is_file():
        inside = sorted(file for file in path.iterdir() if file.is_file())
        yield Arrival(path.name, (path,), tuple(map(_state, inside)))
    elif path.suffix.lower() == ".zip":
        yield Arrival(path.stem, (path,), (_state(path),))
    elif path.suffix.lower() in _LISTS and not path.name.endswith(_JOINTS) and joints.is_file():
        yield Arrival(path.stem, (path, joints), (_state(path), _state(joints)))


def _state(file: Path) -> tuple[int, int]:
    found = file.stat()
    return found.st_size, found.st_mtime_ns
