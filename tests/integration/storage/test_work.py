"""Lists over all kinds of records, and how one came of another, on a database that a demo run left."""

import contextlib
import json
import sqlite3

import pytest

from tests.helpers.storage.demo_database import write_demo
from truepose.storage.database import Database
from truepose.storage.results.items import HELD_OUT, NO_LIMIT, WORSE, WorkKind
from truepose.storage.results.lineage import Lineages, WorkList

_EVERY = tuple(WorkKind)


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    """The file that a demo run left: two sessions, a campaign, and a result of each kind."""
    file = tmp_path_factory.mktemp("left") / "truepose.sqlite3"
    write_demo(file)
    Database(f"sqlite:///{file}").close()  # brings it to the present schema
    return file


@pytest.fixture(scope="module")
def database(left):
    opened = Database(f"sqlite:///{left}")
    yield opened
    opened.close()


@pytest.fixture
def work(database):
    return WorkList(database)


def named(items):
    return [(item.kind.value, item.id) for item in items]


async def test_everything_is_listed_newest_first(work):
    page = await work.page(_EVERY)

    moments = [item.recorded_at for item in page.items]
    assert moments == sorted(moments, reverse=True)
    assert sorted(named(page.items)) == [
        ("campaign", 1),
        ("diagnosis", 1),
        ("identification", 1),
        ("model", 1),
        ("model", 2),
        ("session", 1),
        ("session", 2),
        ("validation", 1),
    ]
    assert page.total == 8


async def test_of_one_moment_a_model_is_newer_than_what_it_came_of(left, tmp_path):
    file = tmp_path / "at-once.sqlite3"
    file.write_bytes(left.read_bytes())
    with contextlib.closing(sqlite3.connect(file)) as connection, connection:
        for table in ("identifications", "diagnoses", "models"):
            connection.execute(f"DROP TRIGGER {table}_no_update")
            connection.execute(f"UPDATE {table} SET recorded_at = '2027'")

    with contextlib.closing(Database(f"sqlite:///{file}")) as database:
        found = await WorkList(database).page(_EVERY, limit=4)

    assert named(found.items) == [("model", 2), ("model", 1), ("diagnosis", 1), ("identification", 1)]


async def test_each_kind_says_its_state_and_its_robot(work):
    found = {(item.kind.value, item.id): item for item in (await work.page(_EVERY)).items}

    assert found["session", 1].state == "finished"
    assert found["session", 1].role == "calibration"
    assert found["campaign", 1].role == HELD_OUT
    assert found["diagnosis", 1].state == "consistent"
    assert found["validation", 1].state == NO_LIMIT
    assert {item.robot for item in found.values()} == {"ABB IRB 120"}
    assert all(item.simulated for item in found.values())


@pytest.mark.parametrize(
    ("limit_mm", "verdict", "passed", "state"),
    [
        (0.1, "conforms", True, "passed"),
        (0.1, "does not conform", False, "failed"),
        (0.1, "cannot be decided", True, "undecided"),
        (0.1, None, True, "passed"),
        (0.1, None, False, "failed"),
        (None, None, True, NO_LIMIT),
        (None, None, False, WORSE),
    ],
)
async def test_a_validation_passes_or_fails_by_the_decision_about_its_limit(
    left, tmp_path, limit_mm, verdict, passed, state
):
    file = tmp_path / "judged.sqlite3"
    file.write_bytes(left.read_bytes())
    decision = None if verdict is None else {"verdict": verdict}
    document = json.dumps({"limit_mm": limit_mm, "decision": decision, "passed": passed})
    with contextlib.closing(sqlite3.connect(file)) as connection, connection:
        connection.execute(
            "INSERT INTO validations (recorded_at, job_id, model_id, campaign_id, document) "
            "VALUES ('2027', 1, 1, 1, ?)",
            [document],
        )

    with contextlib.closing(Database(f"sqlite:///{file}")) as database:
        newest = (await WorkList(database).page([WorkKind.VALIDATION])).items[0]

    assert newest.state == state


async def test_parts_of_a_list_meet_without_a_gap(work):
    whole = (await work.page(_EVERY)).items
    parts = [await work.page(_EVERY, skip=skip, limit=3) for skip in (0, 3, 6, 9)]

    assert tuple(item for part in parts for item in part.items) == whole
    assert [part.total for part in parts] == [8] * 4


@pytest.mark.parametrize(
    ("text", "kinds"),
    [
        ("calibration", {"session"}),
        ("IRB 120", {"session", "campaign", "identification", "diagnosis", "model", "validation"}),
        ("emscon", {"session"}),  # an instrument of its cell
        ("%", set()),  # no pattern: a sign
        ("nothing is called so", set()),
    ],
)
async def test_a_text_finds_what_it_stands_in(work, text, kinds):
    assert {item.kind.value for item in (await work.page(_EVERY, [text])).items} == kinds


async def test_a_session_is_found_by_who_let_the_arm_move(work, left):
    with contextlib.closing(sqlite3.connect(left)) as connection, connection:
        ((person,),) = connection.execute(
            "SELECT DISTINCT person FROM session_states WHERE person IS NOT NULL AND state = 'running'"
        )

    assert ("session", 1) in named((await work.page([WorkKind.SESSION], [person])).items)


async def test_a_number_finds_the_records_of_that_number(work):
    assert ("session", 2) in named((await work.page([WorkKind.SESSION], ["2"])).items)


@pytest.mark.parametrize("digits", [18, 19, 20, 5000])
async def test_a_number_that_no_record_has_finds_nothing_however_long(work, digits):
    assert (await work.page(_EVERY, ("9" * digits,))).items == ()


async def test_robots_are_named_once(work):
    (robot,) = await work.robots()

    assert (robot.name, robot.serial_number, robot.campaigns, robot.diagnoses) == ("ABB IRB 120", "", 1, 1)


@pytest.mark.parametrize(
    ("kind", "number", "family"),
    [
        (
            WorkKind.SESSION,
            1,
            {"campaign 1", "identification 1", "diagnosis 1", "model 1", "model 2", "validation 1"},
        ),
        (WorkKind.MODEL, 2, {"session 1", "session 2", "campaign 1", "identification 1", "diagnosis 1"}),
        (WorkKind.DIAGNOSIS, 1, {"session 1", "session 2", "campaign 1", "identification 1", "model 2"}),
        (
            WorkKind.IDENTIFICATION,
            1,
            {
                "session 1",
                "session 2",
                "campaign 1",
                "model 1",
                "diagnosis 1",
                "model 2",
                "validation 1",
            },
        ),
        (WorkKind.VALIDATION, 1, {"session 1", "session 2", "campaign 1", "identification 1", "model 1"}),
    ],
)
async def test_a_record_has_forebears_and_descendants_and_no_others(database, kind, number, family):
    found = (await Lineages(database).of(kind, number)).items

    assert {f"{item.kind.value} {item.id}" for item in found} == family | {f"{kind.value} {number}"}


async def test_a_record_is_told_from_others_of_its_number(database):
    lineage = await Lineages(database).of(WorkKind.SESSION, 1)

    assert [lineage.item(kind, 1).kind for kind in (WorkKind.MODEL, WorkKind.SESSION)] == ["model", "session"]
    assert lineage.item(WorkKind.SESSION, 2) is None


async def test_a_correction_is_simulated_as_the_readings_of_its_model_are(left, tmp_path):
    file = tmp_path / "corrected.sqlite3"
    file.write_bytes(left.read_bytes())
    named = "recorded_at, job_id, model_id, name, original_sha256, corrected_sha256, asked, document"
    with contextlib.closing(sqlite3.connect(file)) as connection, connection:
        connection.executemany(
            f"INSERT INTO corrections ({named}, targets, file) "
            "VALUES ('2027', 1, ?, 'weld.mod', '', '', '{}', '{}', x'', x'')",
            [(1,), (2,)],  # of an identification, of a diagnosis
        )
    database = Database(f"sqlite:///{file}")
    try:
        found = await WorkList(database).page([WorkKind.CORRECTION])
    finally:
        database.close()

    assert [(item.name, item.robot, item.simulated) for item in found.items] == [
        ("weld.mod", "ABB IRB 120", True)
    ] * 2


async def test_ten_thousand_records_are_listed_and_searched_a_page_at_a_time(left, tmp_path):
    file = tmp_path / "many.sqlite3"
    file.write_bytes(left.read_bytes())
    with contextlib.closing(sqlite3.connect(file)) as connection, connection:
        connection.execute(
            "INSERT INTO campaigns (recorded_at, name, robot, summary, session_ids, archive, campaign) "
            "WITH RECURSIVE numbers(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM numbers WHERE n < 10000) "
            "SELECT '2027-01-01T00:00:00.000+00:00', 'arm ' || n, robot, summary, session_ids, archive, x'' "
            "FROM numbers, campaigns WHERE campaigns.id = 1"
        )
    database = Database(f"sqlite:///{file}")
    try:
        found = await WorkList(database).page(_EVERY, ["arm 9999"])
        last = await WorkList(database).page(_EVERY, skip=9950, limit=50)
    finally:
        database.close()

    assert [item.name for item in found.items] == ["arm 9999"]
    assert (len(last.items), last.total) == (50, 10008)
