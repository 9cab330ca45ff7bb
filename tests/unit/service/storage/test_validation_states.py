"""What a plant tells of a validation: passed or failed where a limit was judged, and nowhere else."""

import json

import pytest

from truepose.storage.plant.result_projections import telling
from truepose.storage.results.items import validation_state

PAIR = {"nominal": {"mean_mm": 0.5, "max_mm": 0.9}, "identified": {"mean_mm": 0.033, "max_mm": 0.081}}


def stored(passed, limit_mm=None, verdict=None):
    """Return a validation as a cell stores it."""
    decision = None if verdict is None else {"verdict": verdict, "limit_mm": limit_mm}
    return {
        "position": PAIR,
        "limit_mm": limit_mm,
        "passed": passed,
        "claimed_mm": 0.03,
        "decision": decision,
    }


@pytest.mark.parametrize(
    ("document", "state"),
    [
        (stored(True, 0.1, "conforms"), "passed"),
        (stored(False, 0.1, "does not conform"), "failed"),
        (stored(True, 0.1, "cannot be decided"), "undecided"),
        (stored(True), "no_limit"),
        (stored(False), "worse"),
        (stored(True, 0.1), "passed"),  # of a program that knew no decision rule
        (stored(False, 0.1), "failed"),
    ],
)
def test_only_a_limit_lets_a_validation_pass_or_fail(document, state):
    told = telling("validations", {"document": json.dumps(document), "model_id": 2, "campaign_id": 3})

    assert (validation_state(document), told.verdict) == (state, state)
    assert (told.document["before_mm"], told.document["after_mm"]) == (0.5, 0.033)
