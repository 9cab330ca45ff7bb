"""Readings that a program delivers as they come: each on disk before it is answered, and exactly once."""

import asyncio
import itertools

import pytest

COLUMNS = ["q1 [deg]", "x [mm]", "y [mm]", "z [mm]"]
READING = [12.5, 512.4, None, 640.25]


@pytest.fixture
async def series(client):
    """The path of a series that holds nothing yet."""
    answer = await client.post("/api/v1/series", json={"name": "left arm", "columns": COLUMNS})
    assert answer.status_code == 201, answer.text
    return answer.headers["Location"]


async def deliver(client, path, first, *readings):
    return await client.post(f"{path}/readings", json={"first": first, "readings": list(readings)})


def numbered(n, first=1):
    return [[0.1 * number, number, -number, 1 / number] for number in range(first, first + n)]


async def test_what_was_delivered_is_listed_as_it_came_in_its_order(client, series):
    await deliver(client, series, 1, READING)
    second = await deliver(client, series, 2, *numbered(5, first=2))

    shown = (await client.get(series)).json()
    listed = (await client.get(f"{series}/readings")).json()
    page = await client.get(f"{series}/readings", params={"after": 3, "limit": 2})
    assert second.json() == {"next_number": 7}
    assert (shown["columns"], shown["readings"], shown["next_number"]) == (COLUMNS, 6, 7)
    assert [one["number"] for one in listed] == [1, 2, 3, 4, 5, 6]
    assert [one["values"] for one in listed] == [READING, *numbered(5, first=2)]
    assert [one["number"] for one in page.json()] == [4, 5]
    assert page.headers["Total-Count"] == "6"
    assert "after=5" in page.headers["Link"]
    assert "Link" not in (await client.get(f"{series}/readings", params={"after": 5})).headers


async def test_whoever_lost_the_answer_sends_the_same_again_and_it_is_kept_once(client, series):
    first = await deliver(client, series, 1, *numbered(2))
    await deliver(client, series, 3, READING)

    again = await deliver(client, series, 1, *numbered(2))

    assert again.status_code == 201
    assert again.json() == first.json() == {"next_number": 3}
    assert (await client.get(series)).json()["readings"] == 3


async def test_the_same_sent_many_times_at_once_is_kept_once(client, series):
    answers = await asyncio.gather(*(deliver(client, series, 1, *numbered(2)) for _ in range(8)))

    assert {answer.status_code for answer in answers} == {201}
    assert (await client.get(series)).json()["readings"] == 2


@pytest.mark.parametrize(
    ("first", "readings", "said"),
    [
        pytest.param(5, [READING], "continues at reading 3, not at 5", id="a gap"),
        pytest.param(1, numbered(1), "sent in different parts", id="other pieces"),
        pytest.param(1, [READING, READING], "a reading is never changed", id="other values"),
        pytest.param(2, [READING], "a reading is never changed", id="within what is kept"),
    ],
)
async def test_what_does_not_follow_is_refused_and_nothing_of_it_is_kept(
    client, series, first, readings, said
):
    await deliver(client, series, 1, *numbered(2))

    refused = await deliver(client, series, first, *readings)

    assert refused.status_code == 409
    assert said in refused.json()["detail"]
    assert [one["values"] for one in (await client.get(f"{series}/readings")).json()] == numbered(2)


async def test_a_reading_has_a_value_for_each_column_or_is_refused_with_its_piece(client, series):
    refused = await deliver(client, series, 1, READING, READING[:3])

    assert refused.status_code == 409
    assert "Reading 2 has 3 values" in refused.json()["detail"]
    assert (await client.get(series)).json()["readings"] == 0


async def test_a_series_that_nobody_began_takes_nothing(client):
    refused = await deliver(client, "/api/v1/series/9", 1, READING)

    assert refused.status_code == 404


@pytest.mark.parametrize("columns", [[], ["x", "x"], [" "]])
async def test_columns_without_names_of_their_own_are_refused(client, columns):
    assert (await client.post("/api/v1/series", json={"name": "a", "columns": columns})).status_code == 422


async def test_two_programs_cannot_take_one_number_for_two_readings(client, series):
    rivals = [deliver(client, series, 1, [number, 0, 0, 0]) for number in range(16)]
    statuses = [answer.status_code for answer in await asyncio.gather(*rivals)]

    assert sorted(statuses) == [201, *itertools.repeat(409, 15)]
    assert (await client.get(series)).json()["readings"] == 1


async def test_a_series_is_brought_as_the_table_that_it_would_have_been(client, series):
    too_early = await client.post(f"{series}/draft")
    await deliver(client, series, 1, *numbered(30))

    draft = (await client.post(f"{series}/draft")).json()
    understood = (await client.get(f"/api/v1/drafts/{draft['id']}/understood")).json()

    assert too_early.status_code == 409
    assert [file["name"] for file in draft["files"]] == ["series 1.csv"]
    table = next(iter(understood["files"]))
    assert table["rows"] == 30
