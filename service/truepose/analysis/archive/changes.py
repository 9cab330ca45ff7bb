"""What is different between two results of the same readings, in figures that fit a line of a table."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

from truepose.analysis.archive.outcome import Document, Found

_SAME_MM = 1e-6  # of a mean error: what a new version of a library may do to the last digits
_SAME = 1e-3  # of a parameter, in its standard uncertainties
_JUDGED = ("validation", "cross_validation", "calibration")  # by what a model is judged, the best first


@dataclass(frozen=True, slots=True)
class Change:
    """A campaign before and now; empty or None where that was not found."""

    campaign: str
    status_before: str = ""
    status_now: str = ""
    mean_before_um: float | None = None  # error of the identified model on what judges it
    mean_now_um: float | None = None
    parameter: str = ""  # the one that changed most, against its standard uncertainty
    changed_by_u: float | None = None
    verdict_before: str = ""
    verdict_now: str = ""
    causes_gone: str = ""
    causes_new: str = ""
    failed: str = ""

    @property
    def compared(self) -> bool:
        """Whether there was a result before, and is one now."""
        return not self.failed and bool(self.status_before or self.verdict_before)

    @property
    def differs(self) -> bool:
        """Whether anything is other than it was."""
        if not self.compared:
            return False
        words = self.status_before != self.status_now or self.verdict_before != self.verdict_now
        means = _apart(self.mean_before_um, self.mean_now_um) > 1e3 * _SAME_MM
        moved = (self.changed_by_u or 0.0) > _SAME
        return bool(words or means or moved or self.causes_gone or self.causes_new)


def change(campaign: str, before: Found | None, now: Found) -> Change:
    """Return what is different; without anything before, what is there now."""
    parameter, by = _largest(before, now)
    causes_before, causes_now = _causes(before), _causes(now)
    diagnosed_twice = before is not None and before.diagnosis is not None
    return Change(
        campaign,
        status_before=_status(before),
        status_now=_status(now),
        mean_before_um=_mean_um(before),
        mean_now_um=_mean_um(now),
        parameter=parameter,
        changed_by_u=by,
        verdict_before=_verdict(before),
        verdict_now=_verdict(now),
        causes_gone=_listed(causes_before, causes_now),
        causes_new=_listed(causes_now, causes_before) if diagnosed_twice else "",
    )


def table(changes: Sequence[Change]) -> list[list[str]]:
    """Return the rows of a table with its head, one campaign a row."""
    head = [field.name for field in fields(Change)]
    return [head, *([_text(getattr(row, name)) for name in head] for row in changes)]


def _text(value: object) -> str:
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def _apart(one: float | None, other: float | None) -> float:
    if one is None or other is None:
        return 0.0 if one == other else math.inf
    return abs(one - other)


def _status(found: Found | None) -> str:
    return "" if found is None or found.identification is None else str(found.identification["status"])


def _verdict(found: Found | None) -> str:
    return "" if found is None or found.diagnosis is None else str(found.diagnosis["verdict"])


def _mean_um(found: Found | None) -> float | None:
    if found is None or found.identification is None:
        return None
    blocks: Document = found.identification["statistics"]
    for name in _JUDGED:
        if blocks.get(name):
            mean_mm = blocks[name]["identified"]["mean_mm"]
            return None if mean_mm is None else 1e3 * float(mean_mm)
    return None


def _causes(found: Found | None) -> frozenset[str]:
    if found is None or found.diagnosis is None:
        return frozenset()
    return frozenset(f"{one['effect']} {one['subject']}" for one in found.diagnosis["findings"])


def _listed(causes: frozenset[str], others: frozenset[str]) -> str:
    return "; ".join(sorted(causes - others))


def _parameters(found: Found | None) -> dict[str, Document]:
    if found is None or found.identification is None:
        return {}
    return {one["name"]: one for one in found.identification["parameters"]}


def _largest(before: Found | None, now: Found) -> tuple[str, float | None]:
    """Return the parameter that both have and that changed most, and by how many standard uncertainties."""
    earlier = _parameters(before)
    changed = [
        (abs(one["value"] - earlier[name]["value"]) / one["standard_uncertainty"], name)
        for name, one in _parameters(now).items()
        if name in earlier and one["standard_uncertainty"]
    ]
    by, name = max(changed, default=(None, ""))
    return name, by
