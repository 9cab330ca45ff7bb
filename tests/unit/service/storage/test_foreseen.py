"""The newest comparison of a type is kept beside the database, until a newer one."""

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


async def test_what_another_version_kept_in_another_form_is_no_comparison(tmp_path):
    kept = Comparisons(tmp_path / "plant.db")
    await kept.keep(to_bytes(FIRST))
    (file,) = (tmp_path / "plant.db.compared").iterdir()
    file.write_bytes(file.read_bytes()[:-1])
    await kept.keep(b'{"robot": "IRB 6700"}')

    assert await Comparisons(tmp_path / "plant.db").of(["IRB 120", "IRB 6700"]) == []
