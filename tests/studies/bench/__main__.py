"""Speed, with the peers beside it: `python -m tests.studies.bench --out out/bench` (or `make bench`).

Prints medians of one core with machine and versions, writes them as JSON, and draws growth with the number of
readings. Peers live in environments of their own under the output folder, fetched once; where one cannot be
fetched, a sentence says so.
"""

import os
import platform
import sys
from pathlib import Path
from typing import Final

import matplotlib
import numpy as np
import scipy
from matplotlib.figure import Figure

from tests.studies.bench import arm, ours
from tests.studies.bench.environments import PEERS, times_of
from tests.studies.bench.timing import Timing, timed
from tests.studies.running import leave, study_options

_SIZES: Final = (50, 1000, 10000)
_GROWTH: Final = (50, 100, 200, 500, 1000, 2000, 5000, 10000)
_CANDIDATES: Final = 5000

Found = dict[str, dict[str, float | int]]


def main() -> None:
    """Measure, print, write."""
    options = study_options(
        __doc__,
        out=Path("out/bench"),
        without_peers=(False, "fetch nothing"),
        without_demo=(False, "leave the demo out"),
    )
    options.out.mkdir(parents=True, exist_ok=True)
    sys.stdout.write(f"{_machine()}\n\n")
    found: Found = {}
    for name, timing in _figures(with_demo=not options.without_demo):
        _note(found, name, timing)
    sentences = [] if options.without_peers else _peers(found, options.out)
    growth = _growth()
    _draw(growth, options.out / "growth.png")
    sys.stdout.write(f"{_machine()}\n")  # the load may be another by now
    document = {"machine": _machine(), "times": found, "growth": growth, "notes": sentences}
    leave(options.out, "bench", document)


def _machine() -> str:
    cpu = Path("/proc/cpuinfo")
    lines = cpu.read_text(encoding="utf-8").splitlines() if cpu.exists() else []
    model = next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), "")
    load = os.getloadavg()[0]
    return (
        f"{model or platform.processor()}, {os.cpu_count()} cores, load {load:.1f}; Python "
        f"{platform.python_version()}, numpy {np.__version__}, scipy {scipy.__version__}"
    )


def _figures(*, with_demo: bool):
    for n in _SIZES:
        yield from ((f"{name}, {n} readings", timing) for name, timing in ours.identifications(n))
        seen = arm.readings(n)
        yield f"numpy sketch: bare solution, {n} readings", timed(lambda seen=seen: arm.identified(seen))
    for n in _SIZES[:2]:
        seen = arm.readings(n)
        yield f"scipy 2-point: bare solution, {n} readings", timed(lambda seen=seen: arm.by_differences(seen))
    yield from ((f"{name}, 10000", timing) for name, timing in ours.forward_kinematics(10000))
    joints = arm.readings(10000).joints
    yield (
        "numpy sketch: forward kinematics, 10000",
        timed(lambda: arm.predicted(np.zeros(6), arm.NOMINAL, arm.TOOL, joints)),
    )
    yield from ((f"{name}, 10000", timing) for name, timing in ours.inverses(10000))
    yield from ours.pair_distances(9905)
    yield from _choices()
    yield from ours.processes(with_demo=with_demo)


def _choices():
    rows = arm.candidate_rows(_CANDIDATES)
    timing, share = ours.choice(rows)
    yield f"choose {ours.CHOSEN} of {_CANDIDATES} (index {share:.3f} of the best of {ours.STARTS})", timing
    yield (
        f"numpy sketch: choose {ours.CHOSEN} of {_CANDIDATES}",
        timed(lambda: arm.chosen(rows, ours.CHOSEN, np.random.default_rng(0))),
    )


def _note(found: Found, name: str, timing: Timing) -> None:
    found[name] = timing._asdict()
    sys.stdout.write(
        f"{name:72s} {1e3 * timing.median_s:10.2f} ms  {1e3 * timing.cpu_s:10.2f} ms of processors, "
        f"at least {1e3 * timing.least_cpu_s:.2f}  ({timing.runs} runs)\n"
    )
    sys.stdout.flush()


def _peers(found: Found, out: Path) -> list[str]:
    """Time every peer on the same arrays; return the sentences about those that could not be."""
    arrays = out / "arrays.npz"
    read = {n: arm.readings(n) for n in _SIZES}
    np.savez(
        arrays,
        table=arm.craig_table(),
        free=arm.craig_free(),
        tool=arm.TOOL,
        **{f"joints_{n}": seen.joints for n, seen in read.items()},
        **{f"measured_{n}": seen.measured for n, seen in read.items()},
    )
    sentences = []
    for peer in PEERS:
        times = times_of(peer, out, arrays)
        if isinstance(times, str):
            sentences.append(times)
            sys.stdout.write(f"{times}\n")
            continue
        for name, timing in times.items():
            _note(found, f"{peer.name}: {name}", Timing(**timing))
    return sentences


def _growth() -> dict[str, list[tuple[int, float]]]:
    lines: dict[str, list[tuple[int, float]]] = {}
    for n in _GROWTH:
        timings = [*ours.identifications(n)]
        seen = arm.readings(n)
        timings.append(("numpy sketch: bare solution", timed(lambda seen=seen: arm.identified(seen), runs=5)))
        for name, timing in timings:
            lines.setdefault(name, []).append((n, timing.median_s))
    return lines


def _draw(growth: dict[str, list[tuple[int, float]]], path: Path) -> None:
    matplotlib.use("Agg")
    figure = Figure(figsize=(6.5, 4.0), layout="constrained")
    axes = figure.subplots()
    for name, points in growth.items():
        sizes, times_s = zip(*points, strict=True)
        axes.loglog(sizes, 1e3 * np.array(times_s), marker="o", label=name)
    axes.set_xlabel("readings")
    axes.set_ylabel("median time [ms]")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    main()
