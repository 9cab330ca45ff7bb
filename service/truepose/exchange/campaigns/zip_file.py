"""A campaign folder as one zip file, never unpacked to disk; a campaign wherever it lies.

Limits: 200,000 rows of seven joints with everything that the format knows are 100 MB of text, so 128 MB for a
file and 256 MB for all are generous, and an archive that expands beyond them was not made by measuring. What
the archive says of itself is judged before anything is inflated, and what it inflates to once more.
"""

import contextlib
import io
import lzma
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any, Final, TypeVar

from truepose.domain.campaign import Campaign
from truepose.exchange.campaigns.folder import (
    DESCRIPTION,
    GREATEST_DESCRIPTION_BYTES,
    campaign_files,
    campaign_from,
    read_campaign,
)
from truepose.exchange.document import GREATEST_BYTES, read_bytes
from truepose.exchange.errors import MissingFileError, UnreadableFileError, UnsafeArchiveError

T = TypeVar("T")
TOTAL_LIMIT_BYTES = 256 * 2**20
_MEMBER_LIMIT = 1000
_ENTRY = b"PK\x01\x02"  # begins a member in the directory at the archive's end
_GREATEST_RATIO = 200  # text of readings shrinks to a fifth, the same row over and over to a hundredth
_SMALL_BYTES = 2**20  # whatever the ratio
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the same campaign gives the same bytes
_READ_WITH_RIGHTS = 0o644 << 16
_ZSTD: Any = getattr(zipfile, "zstd", None)  # since Python 3.14
_DAMAGED: Final[tuple[type[Exception], ...]] = (
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
    struct.error,
    EOFError,
    IndexError,
    OSError,
    *((_ZSTD.ZstdError,) if _ZSTD else ()),
)


def read_campaign_zip(archive: bytes, name: str = "campaign.zip") -> Campaign:
    """Read a campaign from a zip of its folder; the folder itself may be in the zip or not.

    Parameters
    ----------
    archive : bytes
    name : str
        What the user calls the archive, for error messages.

    Raises
    ------
    UnsafeArchiveError
        Members that lead out of the archive, twice the same name, too many or too large ones.
    InputFileError
        As `read_campaign`.
    """
    # From memory and never from a folder: nothing of an archive that is refused is left anywhere.
    return _opened(archive, name, _read)


def read_zip_files(archive: bytes, name: str) -> dict[str, bytes]:
    """Return the files of an archive by their paths in it; limits and errors as of `read_campaign_zip`."""
    return _opened(archive, name, _all_content)


def _opened(archive: bytes, name: str, read: Callable[[zipfile.ZipFile, str], T]) -> T:
    """Return what `read` makes of an archive, its faults in sentences."""
    # By chance the mark stands in packed data as well, and in archives within this one; hence twice the
    # limit. The exact count follows from the directory.
    if archive.count(_ENTRY) > 2 * _MEMBER_LIMIT:  # each takes a thousand bytes once the directory is read
        raise UnsafeArchiveError(f"it has more than the {_MEMBER_LIMIT} members allowed", file=name)
    with contextlib.ExitStack() as closing:
        with _faults_told(name):
            opened = closing.enter_context(zipfile.ZipFile(io.BytesIO(archive)))
        return read(opened, name)


@contextlib.contextmanager
def _faults_told(name: str) -> Iterator[None]:
    """Turn whatever a zip raises that is damaged, or made by nobody honest, into a sentence."""
    try:
        yield
    except _DAMAGED as error:
        raise UnreadableFileError(f"this is not a complete zip file ({error})", file=name) from error
    # Before ValueError, of which it is one.
    except UnicodeDecodeError as error:
        raise UnreadableFileError("a member name in the zip file is not text", file=name) from error
    except (NotImplementedError, RuntimeError, ValueError) as error:
        raise UnreadableFileError(f"the zip file uses an unsupported feature ({error})", file=name) from error


def write_campaign_zip(campaign: Campaign, beside: Mapping[str, bytes] | None = None) -> bytes:
    """Return the campaign folder as a zip without a top folder; equal campaigns give equal bytes.

    `beside` are files by their paths that belong to it and are not read with it.
    """
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        texts = {name: text.encode() for name, text in campaign_files(campaign).items()}
        for name, content in {**texts, **(beside or {})}.items():
            member = zipfile.ZipInfo(name, _EPOCH)
            # The day of a campaign stands in its description. A date here would only give the same campaign
            # other bytes.
            member.compress_type = zipfile.ZIP_DEFLATED
            member.external_attr = _READ_WITH_RIGHTS
            archive.writestr(member, content)
    return stream.getvalue()


def _read(archive: zipfile.ZipFile, name: str) -> Campaign:
    members = _checked_members(archive, name)
    top = _top_folder(members, name)

    def load(file: str) -> bytes:
        member = members.get(str(top / file))
        if member is None:
            raise MissingFileError("there is no such file in the archive", file=file)
        return _content(archive, member, name)

    return campaign_from(load)


def _all_content(archive: zipfile.ZipFile, name: str) -> dict[str, bytes]:
    members, files, total = _checked_members(archive, name), {}, 0
    for path, member in members.items():
        files[path] = _content(archive, member, name)
        total += len(files[path])
        if total > TOTAL_LIMIT_BYTES:  # whatever its directory claims
            raise UnsafeArchiveError(f"the content exceeds {TOTAL_LIMIT_BYTES // 2**20} MB", file=name)
    return files


def _checked_members(archive: zipfile.ZipFile, name: str) -> Mapping[str, zipfile.ZipInfo]:
    """Return the files of the archive by path, after refusing what no honest program writes."""
    entries = archive.infolist()
    if len(entries) > _MEMBER_LIMIT:
        raise UnsafeArchiveError(
            f"{len(entries)} members are more than the {_MEMBER_LIMIT} allowed", file=name
        )
    if sum(entry.file_size for entry in entries) > TOTAL_LIMIT_BYTES:
        raise UnsafeArchiveError(f"the content exceeds {TOTAL_LIMIT_BYTES // 2**20} MB", file=name)
    members: dict[str, zipfile.ZipInfo] = {}
    for entry in entries:
        # Nothing is unpacked to disk here. But the archive is stored as it came, and whoever downloads it may
        # unpack it.
        if not _stays_inside(entry.filename):
            raise UnsafeArchiveError(f"member {entry.filename!r} points outside the archive", file=name)
        # Which of two members of one name is taken differs between programs: what one has checked another
        # would read.
        path = str(PurePosixPath(entry.filename))  # some programs write ./ before each
        if path in members:
            raise UnsafeArchiveError(f"member {entry.filename!r} appears twice", file=name)
        if entry.file_size > max(_SMALL_BYTES, _GREATEST_RATIO * entry.compress_size):
            raise UnsafeArchiveError(
                f"member {entry.filename!r} expands more than {_GREATEST_RATIO}-fold", file=name
            )
        if not entry.is_dir():
            members[path] = entry
    return members


def _stays_inside(path: str) -> bool:
    parts = PurePosixPath(path).parts
    return (
        bool(parts)
        and not path.startswith("/")
        and ".." not in parts
        and "\\" not in path
        and ":" not in parts[0]
    )


def _top_folder(members: Mapping[str, zipfile.ZipInfo], name: str) -> PurePosixPath:
    """Return the folder of the one `campaign.json`; metadata that macOS adds does not count."""
    folders = [
        PurePosixPath(path).parent
        for path in members
        if PurePosixPath(path).name == DESCRIPTION and not path.startswith("__MACOSX/")
    ]
    if not folders:
        raise MissingFileError(f"there is no {DESCRIPTION} in the archive", file=name)
    if len(folders) > 1:
        listed = ", ".join(sorted(str(folder) for folder in folders))
        raise UnreadableFileError(
            f"the archive has several campaigns ({listed}); it must have exactly one", file=name
        )
    return folders[0]


def _content(archive: zipfile.ZipFile, member: zipfile.ZipInfo, name: str) -> bytes:
    """Return the content of a member, whatever size its header claims."""
    # The sizes that were judged are the archive's own words. What comes out of it is counted once more.
    limit = GREATEST_DESCRIPTION_BYTES if member.filename.endswith(DESCRIPTION) else GREATEST_BYTES
    with _faults_told(name), archive.open(member) as stream:
        content = stream.read(limit + 1)
    if len(content) > limit:
        raise UnsafeArchiveError(f"member {member.filename!r} exceeds {limit // 2**20} MB", file=name)
    return content


def read_campaign_at(path: Path) -> Campaign:
    """Read a campaign folder or the zip of one; raises InputFileError."""
    if path.suffix.lower() == ".zip" and not path.is_dir():
        return read_campaign_zip(read_bytes(path), path.name)
    return read_campaign(path)
