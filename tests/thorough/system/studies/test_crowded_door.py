"""The study of the crowded door runs: a small crowd, a session that goes on, uploads that are answered."""

from tests.studies.hardening.crowded_door import crowded
from tests.studies.hardening.giant_upload import giant_zip


async def test_a_session_goes_on_in_a_small_crowd(tmp_path):
    small = {"silent": 10, "slow": 10, "uploads": 1, "asked": 10, "seconds": 12.0}

    found = await crowded(tmp_path, "small", giant_zip(500), **small)

    assert found.interruptions == 0
    assert (found.health_asked, found.health_failed) == (15, 0)
    assert found.uploads == (201,)
    assert found.states[0] == "running"
    assert found.states[-1] in ("aborting", "aborted")
    assert {"silent", "half a head", "slow head", "slow body", "slow chunks"} <= found.kept.keys()
    assert found.with_workers_mb > 10.0
