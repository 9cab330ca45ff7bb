"""Which processes a run has started and which of them still run, found in /proc."""

import time
from pathlib import Path

# In /proc/PID/stat, counted after the name in brackets.
_STATE, _PARENT = 0, 1


def descendants(pid):
    """All children of a process, and theirs."""
    children = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:  # it ended while we looked
            continue
        children.setdefault(int(fields[_PARENT]), []).append(int(stat.parent.name))
    found, left = [], [pid]
    while left:
        left += (own := children.get(left.pop(), []))
        found += own
    return found


def running(pids):
    """Those of the processes that still run."""
    return [pid for pid in pids if Path(f"/proc/{pid}").exists() and not _has_ended(pid)]


def _has_ended(pid):
    # An orphan that has ended waits for init to reap it, which not every container's init does.
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[_STATE] == "Z"
    except OSError:
        return True


def running_after(pids, wait_s):
    """Those that still run after at most `wait_s`."""
    until_s = time.monotonic() + wait_s
    while (left := running(pids)) and time.monotonic() < until_s:
        time.sleep(0.05)
    return left


def named(pids, word):
    """Those whose command line contains a word."""
    return [pid for pid in pids if word in _command(pid)]


def _command(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode()
    except OSError:
        return ""
