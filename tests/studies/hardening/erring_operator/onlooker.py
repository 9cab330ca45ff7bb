"""What must never be, seen from outside: by what is true in the cell and what is on the disk."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tests.studies.hardening.erring_operator.operator import ErringOperator
from tests.studies.taken_up.onlooked_cell import OnlookedCell
from tests.studies.taken_up.service_here import ServiceHere
from truepose_simulators.cell.robot import SpeedLimits
from truepose_simulators.physics.rigid import FloatArray

Line = dict[str, Any]
_SLACK_DEG = 1e-3  # of a target on its way through the wire
_ENDS = {"confirmed", "measured", "moved", "skipped", "reopened", "computed", "suspected", "answered"}
_READS = ("/leg-", "side-", "initialise")


@dataclass(slots=True)
class Phase:
    """Lengths between cups and nests that the session took note of, before or after the pre-calibration."""

    wrong: int = 0  # not of the pair that was asked for
    kept_silently: int = 0  # of the wrong ones, without a question
    right: int = 0
    questioned: int = 0  # of the right ones


@dataclass(slots=True)
class Seen:
    """What an onlooker counts."""

    motions: int = 0
    faults: list[str] = field(default_factory=list)  # motions that must not have been
    before: Phase = field(default_factory=Phase)
    after: Phase = field(default_factory=Phase)
    other_kept: Counter[str] = field(default_factory=Counter)  # wrong zeros and sides, kept silently
    other_wrong: int = 0
    examples: list[str] = field(default_factory=list)
    walked_to_the_end: int = 0  # sessions
    wrong_until_the_end: int = 0  # wrong legs of those
    kept_at_the_end: list[str] = field(default_factory=list)  # of these, never asked about nor refuted


class Onlooker:
    """Watches one session."""

    def __init__(
        self,
        cell: OnlookedCell,
        service: ServiceHere,
        operator: ErringOperator,
        seen: Seen,
        begin: Sequence[Line],
    ) -> None:
        self._cell = cell
        self._operator = operator
        self._service = service
        self._seen = seen
        self._last = begin[-1]["number"] if begin else 0
        self._computed = any(line["kind"] == "computed" for line in begin)
        self._wrong = 0
        self._kept: dict[str, str] = {}  # step -> what it truly was
        self.limits_deg: FloatArray | None = None  # of the cell file, (joints, 2)
        self.speed_mm_s: float | None = None
        cell.on_motion = self._motion

    def _motion(self, waypoints_rad: Sequence[FloatArray], limits: SpeedLimits) -> None:
        self._seen.motions += 1
        seat = self._cell.seat
        if "T" in seat:
            self._fault(f"the arm moves with the ballbar at {seat}")
        last = next((line for line in reversed(self._service.lines()) if _matters(line)), None)
        if last is None or last["kind"] != "confirmed" or not last["step_id"].endswith("/move"):
            self._fault(
                f"the arm moves after {last and (last['kind'], last['step_id'], last['document']['text'])}"
            )
        elif not last["document"]["person"]:
            self._fault("nobody confirmed by name")
        if self.limits_deg is not None:
            self._judge_limits(np.degrees(np.array(waypoints_rad)), limits)

    def _judge_limits(self, targets_deg: FloatArray, limits: SpeedLimits) -> None:
        lower, upper = np.array(self.limits_deg).T
        outside = (targets_deg < lower - _SLACK_DEG) | (targets_deg > upper + _SLACK_DEG)
        if outside.any():
            self._fault(f"the arm is sent to {targets_deg[-1].round(2).tolist()}, outside the cell's limits")
        if self.speed_mm_s is not None and limits.tool_mm_s > self.speed_mm_s + _SLACK_DEG:
            self._fault(f"the arm is sent at {limits.tool_mm_s:g} mm/s, limit {self.speed_mm_s:g}")

    def _fault(self, sentence: str) -> None:
        self._seen.faults.append(sentence)

    def read_ledger(self) -> None:
        """Judge the lengths that were written since this was last asked."""
        for line in self._service.lines(self._last):
            self._last = line["number"]
            self._computed |= line["kind"] == "computed"
            self._forget_what_counts_no_more(line)
            if line["kind"] in {"measured", "suspected"} and line["document"]["length"] is not None:
                self._judge_length(line)

    def _forget_what_counts_no_more(self, line: Line) -> None:
        """Drop wrong lengths that were reopened, read anew, or refuted by the pre-calibration."""
        step_id = line["step_id"]
        takes_along = line["kind"] == "reopened" and step_id.rsplit("/", 1)[-1] in {"move", "initialise"}
        group = step_id.rpartition("/")[0] + "/" if takes_along else None
        found = line["document"].get("precalibration") or {}
        refuted = {f"/pose-{config}/" for config in found.get("exchanged", ())}
        for kept in [*self._kept]:
            again = line["kind"] in {"reopened", "measured"} and kept == step_id
            if again or (group and kept.startswith(group)) or any(pose in kept for pose in refuted):
                del self._kept[kept]

    def take_the_end(self) -> None:
        """Count what a session that has finished keeps of wrong lengths."""
        self._seen.walked_to_the_end += 1
        self._seen.wrong_until_the_end += self._wrong
        self._seen.kept_at_the_end += [f"{step_id} was {seat}" for step_id, seat in self._kept.items()]

    def _is_foreign(self, time_s: float) -> bool:
        since_s = self._operator.foreign_since_s
        return since_s is not None and time_s > since_s and self._service.tells_serial

    def _judge_length(self, line: Line) -> None:
        asked = asked_of(line["step_id"])
        was = self._cell.seat_at(line["document"]["length"]["time_s"])
        if line["kind"] == "measured" and self._is_foreign(line["document"]["length"]["time_s"]):
            self._fault(f"{line['step_id']} was kept of a ballbar that nobody accepted")
        is_right = asked in {was, "-".join(reversed(was.split("-")))}
        silent = line["kind"] == "measured" and line["document"]["suspicion"] is None
        answered = line["kind"] == "measured" and not silent  # its question was counted when it was put
        if answered:
            return
        if "/leg-" not in line["step_id"]:
            self._seen.other_wrong += not is_right
            if silent and not is_right:
                self._seen.other_kept[f"{asked} on {was or 'nothing'}"] += 1
            return
        phase = self._seen.after if self._computed else self._seen.before
        if is_right:
            phase.right += 1
            phase.questioned += not silent
            return
        phase.wrong += 1
        phase.kept_silently += silent
        self._wrong += 1
        if silent:
            self._kept[line["step_id"]] = was
            length = line["document"]["length"]
            self._seen.examples.append(f"{line['step_id']} was {was}, {length['length_mm']:.4f} mm")


def asked_of(step_id: str) -> str:
    """Return what the ballbar has to be on: "B1-T2" of "placement-1/pose-3/leg-1-2"."""
    last = step_id.rsplit("/", 1)[-1]
    if last.startswith("leg-"):
        _, cup, nest = last.split("-")
        return f"B{cup}-T{nest}"
    if last.startswith("side-"):
        letter = "T" if step_id.startswith("tool") else "B"
        _, first, second = last.split("-")
        return f"{letter}{first}-{letter}{second}"
    return "calibrator"


def _matters(line: Line) -> bool:
    entered = line["document"].get("entered")
    state = entered in {"running", "paused", "pausing", "awaiting_confirmation", "aborting"}
    return line["kind"] in _ENDS or (line["kind"] == "control" and state)
