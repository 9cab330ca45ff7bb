"""Every study of simulated campaigns."""

from tests.studies.diagnosis_report.planted.nothing_hidden import everyday, false_alarms
from tests.studies.diagnosis_report.planted.pairs import pairs
from tests.studies.diagnosis_report.planted.single_effects import amplitudes, barely_visible, left_out, power
from tests.studies.diagnosis_report.study import Extent, Study


def studies(extent: Extent) -> tuple[Study, ...]:
    """Return the studies in the order of the report."""
    return (
        power(extent),
        amplitudes(extent),
        false_alarms(extent, heavy_tails=False),
        false_alarms(extent, heavy_tails=True),
        left_out(extent),
        pairs(extent),
        everyday(extent),
        barely_visible(extent),
    )
