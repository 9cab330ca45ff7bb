"""Takes what Windows lacks from every Python that is started with this folder on its path.

What the program asks for on systems of other names alone stays: fcntl, resource, os.nice, os.sysconf.
"""

import asyncio
import os
import signal
import subprocess
import sys

import serial  # noqa: F401 (on Windows it asks the system by other modules)

_GONE = (
    ("fork", "killpg", "posix_fallocate", "sched_getaffinity", "setsid"),
    ("O_CLOEXEC", "O_NOCTTY", "O_NONBLOCK"),
)
_MODULES = ("grp", "pty", "pwd", "termios", "tty")
_KILLED = signal.SIGKILL
_send_signal = subprocess.Popen.send_signal


def _refused(_self, number, *_arguments):
    raise NotImplementedError(f"signal {number}")


def _sent(self, number):
    if number not in (_KILLED, signal.SIGTERM):  # both end a process at once there
        raise ValueError(f"Unsupported signal: {number}")
    _send_signal(self, _KILLED)


for name in (name for names in _GONE for name in names):
    if hasattr(os, name):
        delattr(os, name)
for name in _MODULES:
    sys.modules[name] = None
asyncio.SelectorEventLoop.add_signal_handler = _refused
subprocess.Popen.send_signal = _sent
subprocess.Popen.kill = lambda self: _sent(self, _KILLED)
del signal.SIGKILL
