"""What the operating system says of this process and its disk."""

import os
import shutil
import sys
from pathlib import Path

_RESIDENT = 1  # field of statm: pages in the computer's memory


def free_bytes(folder: Path) -> int:
    """Return how much room is left where a folder lies; 0 where it is gone."""
    try:
        return shutil.disk_usage(folder).free
    except OSError:
        return 0


if sys.platform == "linux":

    def memory_bytes() -> int:
        """Return what of this process is in the computer's memory."""
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[_RESIDENT]
        return int(pages) * os.sysconf("SC_PAGE_SIZE")

elif sys.platform == "win32":

    def memory_bytes() -> int:
        """Return 0: the standard library cannot tell."""
        return 0

else:
    import resource

    def memory_bytes() -> int:
        """Return the most that this process ever had in the computer's memory."""
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
