"""The newest comparison of a type is kept beside the database, until a newer one."""

import asyncio
import threading

from truepose.storage.caches import Comparisons, FleetComparison, LimitForecast, to_bytes

ROBOT = LimitForecast(
    "120-1", "backlash", "joint 5", 0.0, "2026-06-01", 0.06, 0.012, "2026-11-20", None, "2026-12-01"
)
FIRST = FleetComparison("IRB 120", "2026-11-20 08:00 UTC", 7, 0.1, (ROBOT,))
LATER = FleetComparison("IRB 120", "2026-11-21 08:00 UTC", 9, 0.1, ())
OTHER = FleetComparison("IRB 6700", "2026-11-20 08:00 UTC", 8, 0.1, ())


async def test_what_was_never_compared_has_no_comparison(tmp_path):
    assert await Comparisons(tmp_path / "plant.db").of(["IRB 120"]) == []


async def test_the_newest_comparison_of_each_type_is_there_again_after_a_start(tmp_path):
    kept = Comparisons(tmp_path / "plant.db")
    for one in (FIRST, OTHER, LATER, FIRST):  # the last of fewer campaigns: workers were away
        await kept.keep(to_bytes(one))

    for comparisons in (kept, Comparisons(tmp_path / "plant.db")):
        assert await comparisons.of(iter(["IRB 6700", "IRB 120", "IRB 120", "another"])) == [LATER, OTHER]


async def test_a_comparison_that_comes_while_the_one_before_is_read_stays(tmp_path):
    await Comparisons(tmp_path / "plant.db").keep(to_bytes(FIRST))
    kept = Comparisons(tmp_path / "plant.db")
    read, reads, kept_meanwhile = kept._folder.get, [], threading.Event()

    def read_slowly(of):
        found = read(of)
        reads.append(of)
        if len(reads) == 1:
            kept_meanwhile.wait(60)
        return found

    kept._folder.get = read_slowly
    looking = asyncio.create_task(kept.of(["IRB 120"]))
    async with asyncio.timeout(60):
        while not reads:
            await asyncio.sleep(0)
    await kept.keep(to_bytes(LATER))
    kept_meanwhile.set()

    assert await looking == await kept.of(["IRB 120"]) == [LATER]


async def test_what_another_version_kept_in_another_form_is_no_comparison(tmp_path):
    kept = Comparisons(tmp_path / "plant.db")
    await kept.keep(to_bytes(FIRST))
    (file,) = (tmp_path / "plant.db.compared").iterdir()
    file.write_bytes(file.read_bytes()[:-1])
    await kept.keep(b'{"robot": "IRB 6700"}')

    assert await Comparisons(tmp_path / "plant.db").of(["IRB 120", "IRB 6700"]) == []
