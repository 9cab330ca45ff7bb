"""What a session with the ballbar leaves, as far as its lines tell."""

import pytest

from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.sessions.ballbar.state import leaves_attached

ASKED = ("tool/initialise", EntryKind.SHOWN)
POSE = "placement-1/pose-1"


@pytest.mark.parametrize(
    ("lines", "left"),
    [
        ([], None),
        ([("placement-1/place", EntryKind.SHOWN)], None),
        ([ASKED], True),
        ([ASKED, ("tool/detach", EntryKind.CONFIRMED)], False),
        ([(f"{POSE}/move", EntryKind.CONFIRMED)], False),
        ([(f"{POSE}/move", EntryKind.CONFIRMED), (f"{POSE}/leg-1-1", EntryKind.SHOWN)], True),
        ([ASKED, ("tool/detach", EntryKind.CONFIRMED), ("tool/detach", EntryKind.REOPENED)], True),
    ],
)
def test_what_it_leaves_is_known_by_its_last_step_with_the_ballbar(lines, left):
    assert leaves_attached(LedgerEntry(step, kind, 1.0) for step, kind in lines) is left
