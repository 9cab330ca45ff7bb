"""A service on a server's database that is killed in a ballbar session loses nothing and doubles nothing.

`python -m tests.studies.interruptions --database URL` kills it as often as one likes.
"""

import pytest

from tests.integration.web.ballbar_bench import PLACE
from tests.studies.interruptions.__main__ import Tally, interrupt, report
from truepose.storage.integrity.verification import verify_left_at

pytestmark = [pytest.mark.engine("postgresql"), pytest.mark.usefixtures("forked_processes")]


async def test_a_killed_service_loses_and_doubles_nothing_and_moves_nothing(database_url, tmp_path):
    tally, wanted = Tally(), {"poses": 13, "placements": [PLACE]}

    await interrupt(tally, 2, seed=1, folder=tmp_path, wanted=wanted, database=database_url)

    assert report(tally)["pass"], report(tally)
    assert tally.acknowledged > 0
    assert verify_left_at(database_url).findings == ()
