"""A service that is killed in the middle of a ballbar session loses nothing and doubles nothing.

A handful of kills; `python -m tests.studies.interruptions` makes two hundred.
"""

from tests.integration.web.ballbar_bench import PLACEMENT
from tests.studies.interruptions.__main__ import Tally, interrupt, report


async def test_a_killed_service_loses_and_doubles_nothing_and_moves_nothing(tmp_path):
    tally = Tally()

    await interrupt(tally, 3, seed=1, folder=tmp_path, wanted={"placements": [PLACEMENT]})

    assert report(tally)["pass"], report(tally)
    assert tally.kills == 3
    assert tally.acknowledged > 0
