"""The version of the program, as results and reports carry it."""

import functools
import hashlib
from pathlib import Path

__version__ = "0.1.0"


@functools.cache
def program_sha256() -> str:
    """Return a hash of the program's own files: where it is another, what the program draws may be too."""
    here, found = Path(__file__).parent, hashlib.sha256()
    for file in sorted(path for path in here.rglob("*.*") if path.suffix != ".pyc" and path.is_file()):
        found.update(f"{file.relative_to(here)}\0{file.stat().st_size}\0".encode())
        found.update(file.read_bytes())
    return found.hexdigest()
