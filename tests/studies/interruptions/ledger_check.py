"""What must hold of a session's ledger after the service was killed, by what the person knows."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from truepose.demo.simulated_operator import OwnLedger

Entry: TypeAlias = dict[str, Any]  # as the service sends it

_AWAITS = "awaiting_confirmation"  # what a service that was started anew enters


@dataclass(frozen=True, slots=True)
class Faults:
    """What was found wrong, a sentence each."""

    lost: tuple[str, ...] = ()
    doubled: tuple[str, ...] = ()
    moved: tuple[str, ...] = ()  # before a person had confirmed

    def __bool__(self) -> bool:
        return bool(self.lost or self.doubled or self.moved)


def faults(own: OwnLedger, before: Sequence[Entry], after: Sequence[Entry]) -> Faults:
    """Compare the ledger after a restart with what the person knows and with what was read of it before."""
    return Faults(tuple(_lost(own, before, after)), tuple(_doubled(after)), tuple(_moved(after)))


def _lost(own: OwnLedger, before: Sequence[Entry], after: Sequence[Entry]) -> Iterator[str]:
    by_number = {entry["number"]: entry for entry in after}
    for act in own.acts:
        kept = None if act.entry is None else by_number.get(act.entry)
        if act.entry is not None and (kept is None or kept["key"] != act.key):
            yield f"Entry {act.entry} of {act.act} at {act.step_id} was acknowledged and is not kept."
    for entry in before:
        if by_number.get(entry["number"]) != entry:
            yield f"Entry {entry['number']} was read before and is not there as it was."


def _doubled(entries: Sequence[Entry]) -> Iterator[str]:
    keys: set[str] = set()
    measured: set[str] = set()
    for entry in entries:
        if entry["key"] in keys:
            yield f"The key {entry['key']} is kept twice."
        keys |= {entry["key"]} - {None}
        if entry["kind"] == "reopened":
            measured.clear()  # what it takes along may be read again
        if entry["kind"] == "measured":
            if entry["step_id"] in measured:
                yield f"The length of {entry['step_id']} is kept twice."
            measured.add(entry["step_id"])


def _moved(entries: Sequence[Entry]) -> Iterator[str]:
    """Name every arrival without a person's confirmation of that very motion since the last restart."""
    confirmed: str | None = None
    for entry in entries:
        if entry["kind"] == "control" and entry["text"].startswith(_AWAITS):
            confirmed = None
        elif entry["kind"] == "confirmed":
            confirmed = entry["step_id"]
        elif entry["kind"] == "moved" and confirmed != entry["step_id"]:
            yield f"The robot moved at {entry['step_id']} without a confirmation."
