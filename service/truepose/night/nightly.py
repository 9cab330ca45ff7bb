"""`truepose nightly`: all that can be tried without a person, set beside the nights before."""

import time
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from truepose.demo.processes import DATABASE
from truepose.demo.progress import RunProgress, progress_bar
from truepose.domain.errors import TrueposeError
from truepose.night.bad_lines import bad_lines
from truepose.night.calibrated_cells import calibrated_cells
from truepose.night.check import NightCase, NightRequest
from truepose.night.errors import UnknownCaseError
from truepose.night.faulty_sessions import FaultySession, KilledService
from truepose.night.history import HISTORY, append_night, read_history
from truepose.night.planted_causes import planted_causes
from truepose.night.results import CaseOutcome, NightRun, print_night, write_night
from truepose.night.trackerless_cells import ballbar_cells, loop_cells

# Accuracy is compared between nights: only the program may change in between, not the robot.
_SAME_CELLS = 0


def night_cases(seed: int, benches: tuple[str, ...] = ()) -> list[NightCase]:
    """Return the cases of a night; `seed` draws what is to be another every night.

    `benches` are those of drivers beside the installed ones (`MODULE:NAME`); raises UnknownCaseError.
    """
    return [
        *calibrated_cells(_SAME_CELLS),
        *ballbar_cells(_SAME_CELLS),
        *loop_cells(_SAME_CELLS),
        *planted_causes(seed),
        *(FaultySession(scenario, seed) for scenario in ("irb120-clean", "lrmate-fanuc", "ur10-clean")),
        KilledService(seed),
        *bad_lines(seed, benches),
    ]


_FAILED: Final = 1
_SERVICE_FAILED: Final = 3
_INTERRUPTED: Final = 130


def run_nightly(request: NightRequest, cases: Sequence[NightCase] | None = None) -> int:
    """Run all cases one after the other; leave junit.xml, report.html, result.json and their data.

    A whole night is added to `history.jsonl`; single cases are not.

    Parameters
    ----------
    request : NightRequest
    cases : sequence of NightCase, optional
        By default those of `night_cases`.

    Returns
    -------
    int
        Exit status: 0 every figure was reached, 1 one was not, 3 the service or a simulated cell failed,
        130 interrupted.

    Raises
    ------
    UnknownCaseError, UnreadableHistoryError
        The request cannot be met; nothing was run.
    OSError
        The folder cannot be written.
    """
    chosen = _chosen(night_cases(request.seed, request.benches) if cases is None else cases, request.only)
    request.out.mkdir(parents=True, exist_ok=True)
    earlier = tuple(read_history(request.out / HISTORY))
    began, began_s = datetime.now(UTC), time.perf_counter()
    outcomes: list[CaseOutcome] = []
    with progress_bar() as progress:
        try:
            for case in chosen:
                outcomes.append(_outcome(case, request.out / case.name, progress))
                progress.say(_in_short(outcomes[-1]))
        except KeyboardInterrupt:
            progress.say(f"Interrupted while {progress.doing}; no case is judged. {_kept(request.out)}")
            return _INTERRUPTED
    night = NightRun(request, began, time.perf_counter() - began_s, tuple(outcomes), earlier)
    if not request.only:
        append_night(request.out / HISTORY, night.remembered)
    write_night(night, request.out)
    print_night(night, request.out)
    return _status(outcomes)


def _chosen(cases: Sequence[NightCase], only: Sequence[str]) -> list[NightCase]:
    known = [case.name for case in cases]
    for name in only:
        if name not in known:
            raise UnknownCaseError(f'Unknown case "{name}"; available cases: {", ".join(known)}.')
    return [case for case in cases if not only or case.name in only]


def _outcome(case: NightCase, folder: Path, progress: RunProgress) -> CaseOutcome:
    began_s = time.perf_counter()
    progress.chapter(case.name)
    folder.mkdir(parents=True, exist_ok=True)
    for left in folder.glob(f"{DATABASE}*"):  # of a night before, with the state of its cell
        left.unlink()
    try:
        checks = tuple(case.run(folder, progress))
    except TrueposeError as error:
        progress.say(str(error))
        return CaseOutcome(case, (), str(error), time.perf_counter() - began_s)
    return CaseOutcome(case, checks, None, time.perf_counter() - began_s)


def _in_short(outcome: CaseOutcome) -> str:
    """Return what a log shows of a case at once; the figures follow when the night is over."""
    missed = ", ".join(check.figure for check in outcome.checks if not check.passed)
    said = outcome.error or (f"missed {missed}" if missed else "passed")
    return f"{outcome.case.name}: {said} ({outcome.wall_s:.0f} s)"


def _kept(out: Path) -> str:
    return f"The measurements so far are kept in the folders of {out}."


def _status(outcomes: Sequence[CaseOutcome]) -> int:
    if any(outcome.error is not None for outcome in outcomes):
        return _SERVICE_FAILED
    return 0 if all(outcome.passed for outcome in outcomes) else _FAILED
