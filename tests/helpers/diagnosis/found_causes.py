"""What must hold where a hidden effect is called found."""

from tests.studies.diagnosis_report.planted.cases import BARELY_VISIBLE, FOR_INFORMATION, REALISTIC

# Amplitudes are estimated with their standard uncertainty: beyond three of them lies 0.3 % of all.
_SIGMAS = 3.0


def case(part):
    """Return the one hidden effect whose label holds these words."""
    (found,) = (one for one in (*REALISTIC, *FOR_INFORMATION, *BARELY_VISIBLE) if part in one.label)
    return found


def assert_found(diagnosis, outcome):
    """Everything hidden is named, nothing else is, and nothing is left to explain."""
    assert outcome.verdict == "explained", diagnosis.message
    assert outcome.all_named, diagnosis.message
    assert outcome.wrong == ()
    assert all(one.order_found is not False for one in outcome.named)
    scores = [score for one in outcome.named for score in one.scores]
    assert all(abs(score) < _SIGMAS for score in scores), scores
