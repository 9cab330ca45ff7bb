"""What to measure next: actions and configurations that would tell causes apart."""

from service.diagnosis.left import Left
from service.diagnosis.selection import Selected
from service.diagnosis.start import Start
from service.domain.diagnosis import Finding, NextMeasurement
from service.effects.causes import Candidate


def next_measurements(
    start: Start,
    selected: Selected,
    groups: tuple[tuple[str, tuple[Candidate, ...]], ...],
    findings: tuple[Finding, ...],
    left: Left,
) -> tuple[NextMeasurement, ...]:
    """Return what would separate rivals, or show what nothing explains."""
    return ()
