"""What became of sessions whose database refused."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

TOO_LATE = "the session had ended"


@dataclass
class Outcome:
    """One session."""

    kind: str  # tracker, ballbar
    fault: str
    moment: str  # at which the fault began
    lasted_s: float
    kept: int = 0  # readings that were shown, lines that were acknowledged
    repeated: int = 0  # acts that were sent again with their key
    told: bool = False  # the service said that it is in trouble
    state: str = "not at its end"  # in which it was left
    came_to_its_end: bool = False  # finished, ended as asked, or on its way as far as it was followed
    wrong: list[str] = field(default_factory=list)  # lost, doubled, moved, damaged: a sentence each


@dataclass
class Found:
    """All of them."""

    sessions: Sequence[Outcome]


def told(found: Found) -> str:
    """Return what was found, in words."""
    return "".join(_of_a_kind(kind, found.sessions) for kind in ("tracker", "ballbar"))


def _of_a_kind(kind: str, sessions: Sequence[Outcome]) -> str:
    those = [session for session in sessions if session.kind == kind]
    stuck = [f"{s.fault}, {s.moment}: {s.state}" for s in those if not s.came_to_its_end]
    wrong = [sentence for session in those for sentence in session.wrong]
    return (
        f"{len(those)} {kind} sessions, {sum(s.moment == TOO_LATE for s in those)} that had ended before, "
        f"{sum(s.told for s in those)} of which the service said something, "
        f"{sum(s.lasted_s for s in those):.0f} s of refusals: {sum(s.kept for s in those)} kept, "
        f"{sum(s.repeated for s in those)} acts repeated, wrong {wrong or 'nothing'}; "
        f"ended {dict(Counter(s.state for s in those))}, stuck {stuck or 'none'}\n"
    )
