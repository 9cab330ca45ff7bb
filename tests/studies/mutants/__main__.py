"""How many of the errors that somebody could make in a room do its own unit tests see?

`python -m tests.studies.mutants --out out/mutants --mutants 60 --seed 1` draws places of the product at
random, changes one at a time in a copy of the checkout (a comparison, an operator, a sign, a number, the
order of two arguments, what is returned, a line left out) and runs those files of `tests/unit/service/ROOM`
that run the function. Every mutant is in mutants.json; those that no test saw are printed. Such a one is a
place to look at and no verdict: some changes change nothing. `--kinds` and `--rooms` draw from some of
them.
"""

import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tests.helpers.checkout import CHECKOUT
from tests.studies.mutants.functions import RAN
from tests.studies.mutants.mutations import KINDS, Mutation, mutations_of
from tests.studies.running import leave, study_options

_COPIED = ("service", "drivers", "simulators", "tests", "migrations", "docs")
_UNIT_TESTS = Path("tests/unit/service")
_LIMIT_S = 900.0  # for a mutant that goes round in circles


def main() -> None:
    """Draw, try, and say what was seen."""
    rooms = sorted(path.name for path in (CHECKOUT / _UNIT_TESTS).glob("[a-z]*/"))
    options = study_options(
        __doc__, out=Path, mutants=400, seed=1, rooms=",".join(rooms), kinds=",".join(KINDS)
    )
    out, told = options.out.resolve(), []
    with tempfile.TemporaryDirectory() as copy:
        _copy_to(Path(copy))
        os.chdir(copy)
        for room, drawn in _drawn(options).items():
            ran = _learnt(room)
            told += [_tried(mutation, ran) for mutation in drawn]
    leave(out, "mutants", told)
    for kind in ("all", *KINDS):
        found = Counter(trial["found"] for trial in told if kind in {"all", trial["kind"]})
        sys.stdout.write(f"{kind}: {found['seen']} of {found.total()} seen, {found['not run']} not run\n")


def _drawn(options: argparse.Namespace) -> dict[str, list[Mutation]]:
    every = [
        (room, mutation)
        for room in options.rooms.split(",")
        for mutation in mutations_of(room)
        if mutation.kind in options.kinds.split(",")
    ]
    drawn: dict[str, list[Mutation]] = {}
    for room, mutation in random.Random(options.seed).sample(every, min(options.mutants, len(every))):
        drawn.setdefault(room, []).append(mutation)
    return drawn


def _copy_to(folder: Path) -> None:
    for name in _COPIED:
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(CHECKOUT / name, folder / name, symlinks=True, ignore=ignored)
    shutil.copy2(CHECKOUT / "pyproject.toml", folder)


def _learnt(room: str) -> dict[str, list[str]]:
    if _status("-p", "tests.studies.mutants.functions", str(_UNIT_TESTS / room)) != 0:
        sys.exit(f"the tests of {room} fail as they are")
    ran: dict[str, list[str]] = json.loads(RAN.read_text(encoding="utf-8"))
    return ran


def _tried(mutation: Mutation, ran: dict[str, list[str]]) -> dict[str, str]:
    source, before, after = mutation.source()
    found = _found(mutation, source, mutation.tests(ran))
    place = f"{mutation.file}:{mutation.line}"
    if found != "seen":
        sys.stdout.write(f"{place}  {found}: {before} -> {after}\n")
        sys.stdout.flush()
    return {"place": place, "kind": mutation.kind, "was": before, "is": after, "found": found}


def _found(mutation: Mutation, source: str, tests: list[str]) -> str:
    if not tests:
        return "not run"
    kept = mutation.file.read_bytes()
    mutation.file.write_text(source, encoding="utf-8")
    try:
        return "not seen" if _status("-x", *tests) == 0 else "seen"
    except subprocess.TimeoutExpired:
        return "seen"
    finally:
        mutation.file.write_bytes(kept)


def _status(*asked: str) -> int:
    path = os.pathsep.join(str(Path(name).resolve()) for name in ("", "service", "drivers", "simulators"))
    # Of two sources of one size within a second, a compiled one could be taken for the other.
    once = {"PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *asked]
    return subprocess.run(command, env=os.environ | once, capture_output=True, timeout=_LIMIT_S).returncode


main()
