"""The folder of the user's own data."""

import os
import sys
from pathlib import Path


def data_folder() -> Path:
    """Return the folder of the user's own data, where the platform keeps such things.

    Not the working directory: measurements must not depend on where somebody happened to stand.
    """
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "truepose"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "truepose"
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "truepose"
