"""What many sessions amount to."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from tests.studies.hardening.erring_operator.onlooker import Phase, Seen
from tests.studies.hardening.erring_operator.operator import ErringOperator
from tests.studies.taken_up.onlooked_cell import OnlookedCell


@dataclass(slots=True)
class Tally:
    """Counts over sessions."""

    sessions: int = 0
    accidents: int = 0  # a magnet torn off by a motion
    motions_attached: int = 0
    seen: Seen = field(default_factory=Seen)
    errors: Counter[str] = field(default_factory=Counter)
    acknowledged: int = 0
    lost: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether something moved, nothing of it with the ballbar attached, and nothing is lost or broken."""
        wrong = self.seen.faults or self.lost or self.broken
        return self.seen.motions > 0 and not wrong

    def take(self, operator: ErringOperator, lines: Sequence[Mapping[str, Any]], cell: OnlookedCell) -> None:
        """Add a session that is over."""
        self.sessions += 1
        self.accidents += cell.hands.accidents
        self.motions_attached += cell.hands.motions_attached
        self.errors.update(operator.errors)
        self.broken += operator.broken
        keys = {line["number"]: line["key"] for line in lines}
        self.acknowledged += len(operator.acknowledged)
        self.lost += [key for number, key in operator.acknowledged.items() if keys.get(number) != key]

    def name_faults(self, first: int, session: str) -> None:
        """Say of the newest faults in which session they were."""
        self.seen.faults[first:] = [f"{session}: {fault}" for fault in self.seen.faults[first:]]


def joined(tallies: Sequence[Tally]) -> Tally:
    """Add up what several processes counted."""
    whole = Tally()
    for tally in tallies:
        for name in ("sessions", "accidents", "motions_attached", "acknowledged"):
            setattr(whole, name, getattr(whole, name) + getattr(tally, name))
        whole.errors.update(tally.errors)
        whole.lost += tally.lost
        whole.broken += tally.broken
        whole.seen.motions += tally.seen.motions
        whole.seen.faults += tally.seen.faults
        whole.seen.examples += tally.seen.examples
        whole.seen.other_kept.update(tally.seen.other_kept)
        whole.seen.other_wrong += tally.seen.other_wrong
        whole.seen.walked_to_the_end += tally.seen.walked_to_the_end
        whole.seen.wrong_until_the_end += tally.seen.wrong_until_the_end
        whole.seen.kept_at_the_end += tally.seen.kept_at_the_end
        _add(whole.seen.before, tally.seen.before)
        _add(whole.seen.after, tally.seen.after)
    return whole


def _add(to: Phase, phase: Phase) -> None:
    for item in fields(Phase):
        setattr(to, item.name, getattr(to, item.name) + getattr(phase, item.name))


def report(tally: Tally) -> dict[str, Any]:
    """Return the tally as a document."""
    document = asdict(tally)
    # `asdict` takes a Counter apart into pairs
    document["errors"], document["seen"]["other_kept"] = dict(tally.errors), dict(tally.seen.other_kept)
    document["pass"] = tally.passed
    for name in ("before", "after"):
        phase = document["seen"][name]
        phase["kept_silently_share"] = phase["kept_silently"] / max(1, phase["wrong"])
        phase["questioned_share"] = phase["questioned"] / max(1, phase["right"])
    return document
