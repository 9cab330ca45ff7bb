"""Tasks that workers in other processes are given in tests; these find them by this module's name."""

import os
import signal
import time
from pathlib import Path

import numpy as np

from truepose.domain.errors import ConfigurationError


def sums_of_noise(size, seed):
    """What a resampling does: draw, factor, solve."""
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((size, size))
    return np.linalg.solve(matrix @ matrix.T + np.eye(size), rng.standard_normal(size)).tobytes()


def waited_for(wait_s, _seed):
    """Take so long, and answer with it."""
    time.sleep(wait_s)
    return wait_s


def odd_is_refused(number, _seed):
    """Answer for even numbers only."""
    if number == 3:
        raise ConfigurationError("3 cannot be halved.")
    if number % 2:
        raise ZeroDivisionError(number)
    return number // 2


def killed_at_first(marks, _seed):
    """End the process in which this runs as often as there are marks left, then answer."""
    left = sorted(Path(marks).glob("*"))
    if left:
        left[0].unlink()
        os.kill(os.getpid(), signal.SIGKILL)
    return "at last"


def process_of(_item, _seed):
    """Return what the process may use, and its number."""
    return os.getpid(), os.environ["OPENBLAS_NUM_THREADS"]


def cannot_travel(_item, _seed):
    """Answer with what no pipe takes."""
    return lambda: None
