"""Whether two computers compute the same bits: the same versions, one thread, the same arithmetic.

Versions alone do not say it: a linear algebra library has other kernels for other processors, which add the
same numbers in another order. A small sum of what an identification is made of is computed and compared.
"""

import functools
import hashlib
import os
import platform
from dataclasses import dataclass

import numpy as np
import scipy

from truepose.start import ONE_THREAD
from truepose.version import __version__, program_sha256

_SIZE = 60  # smaller than what a linear algebra library gives to several threads


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """What the bits of a result depend on."""

    truepose: str
    python: str
    numpy: str
    scipy: str
    threads: str  # of the linear algebra library
    sample: str  # hash of what the processor makes of some arithmetic

    def unlike(self, other: "Arithmetic") -> str:
        """Return in words in what `other` differs, empty where in nothing."""
        for name in ("truepose", "python", "numpy", "scipy"):
            here, there = getattr(self, name), getattr(other, name)
            if here != there:
                return f"has {name} {there}, but this program has {here}; install the same version there"
        if other.threads != self.threads:
            return (
                f"uses {other.threads} linear algebra threads; start it with "
                f"{' '.join(f'{name}=1' for name in ONE_THREAD)}"
            )
        if other.sample != self.sample:
            return (
                "has a processor that rounds differently; set the same OPENBLAS_CORETYPE and "
                "NPY_DISABLE_CPU_FEATURES on both computers (docs/computing.md)"
            )
        return ""


@functools.cache
def arithmetic() -> Arithmetic:
    """Return what the bits of results depend on here; threads are those of a worker, which are one."""
    return Arithmetic(
        program(), platform.python_version(), np.__version__, scipy.__version__, _threads(), _sample()
    )


def program() -> str:
    """Return the version with a hash of the program's files: between releases its number stands still."""
    return f"{__version__}+{program_sha256()[:12]}"


def _threads() -> str:
    """Return how many threads the environment allows: "1", or what else it says."""
    stated = {os.environ.get(name, "") for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")} - {""}
    return ", ".join(sorted(stated)) or "several"


def _sample() -> str:
    # One of each kind of kernel that an identification uses: a library may choose another one for this
    # processor in one of them only.
    rng = np.random.default_rng(20260101)
    matrix = rng.standard_normal((_SIZE, _SIZE))
    normal = matrix @ matrix.T + np.eye(_SIZE)
    found = (
        normal,
        np.linalg.cholesky(normal),
        np.linalg.qr(matrix)[1],
        np.linalg.solve(normal, matrix),
        np.linalg.eigvalsh(normal),
        np.linalg.svd(matrix, compute_uv=False),
        np.sin(matrix) + np.exp(matrix) + np.arctan2(matrix, matrix.T),
        np.einsum("ij,jk,ki->i", matrix, normal, matrix, optimize=True),
        matrix.sum(axis=0),
    )
    return hashlib.sha256(b"".join(np.ascontiguousarray(one).tobytes() for one in found)).hexdigest()[:16]
