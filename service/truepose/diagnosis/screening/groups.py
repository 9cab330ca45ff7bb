"""Groups: picks of one cause on one subject make one finding; many joints that share a cause make one too."""

from collections.abc import Iterable, Sequence

from truepose.effects.causes import Candidate
from truepose.effects.cells import plural_of
from truepose.effects.joints.joint_harmonics import NAME as HARMONICS

Group = tuple[str, tuple[Candidate, ...]]  # subject and picks

_MANY = 3  # joints that share a cause from this number on
_ORDERS_APART = 2  # waves of one joint that are told one by one; more are told together


def grouped(picks: Sequence[Candidate]) -> tuple[Group, ...]:
    """Return subjects and their picks, in the order in which they were found."""
    groups: dict[tuple[str, str, float], list[Candidate]] = {}
    for pick in picks:
        groups.setdefault((pick.effect, _subject(pick, picks), _apart(pick, picks)), []).append(pick)
    return tuple((key[1], tuple(group)) for key, group in groups.items())


def names_of(picks: Iterable[Candidate]) -> tuple[str, ...]:
    """Return the names of all parameters of some picks."""
    return tuple(name for pick in picks for name in pick.names)


def _subject(pick: Candidate, picks: Sequence[Candidate]) -> str:
    plural = plural_of(pick.effect)
    if not plural:
        return pick.subject
    subjects = {other.subject for other in picks if other.effect == pick.effect}
    return plural if plural in subjects or len(subjects) >= _MANY else pick.subject


def _apart(pick: Candidate, picks: Sequence[Candidate]) -> float:
    """Tell waves of one joint apart by their order while they are few."""
    if pick.effect != HARMONICS:
        return 0.0
    same = [other for other in picks if (other.effect, other.subject) == (pick.effect, pick.subject)]
    return pick.variant if len(same) <= _ORDERS_APART else 0.0
