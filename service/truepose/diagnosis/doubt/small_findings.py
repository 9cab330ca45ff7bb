"""Small findings: they are there and stay in the model, but the robot would hardly err less without them."""

from truepose.domain.results.diagnosis import Finding

_SMALL = 0.02  # of the held-out error


def parted(findings: tuple[Finding, ...]) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """Return findings that count as causes and those that are small; the leading one always counts."""
    small = tuple(finding for finding in findings[1:] if _is_small(finding))
    return tuple(finding for finding in findings if finding not in small), small


def _is_small(finding: Finding) -> bool:
    """Whether it takes less off the held-out error than anybody would act upon; bad readings stay bad."""
    gain = finding.gain
    if gain is None or not finding.parameters:
        return False
    return gain.rms_after_mm > (1.0 - _SMALL) * gain.rms_before_mm
