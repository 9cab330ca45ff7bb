"""Sessions that run by themselves as a tablet asks for them: guided, revised, followed."""

import asyncio
import json

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import command, prompt_id
from tests.integration.web.bench import planned
from truepose.analysis.job_queue.accuracy_tasks import ExpectedAccuracy, SessionForecast

ADA = {"person": "Ada Byron", "tablet": "tablet-1"}


async def press(client, path, act, key=None, **more):
    return await command(client, path, act, key or f"{act}-{more.get('step_id')}", **ADA, **more)


async def pressed(client, path, act, key=None, **more):
    reply = await press(client, path, act, key, **more)
    assert reply.status_code == 200, reply.text
    return reply.json()


async def guide(client, path):
    reply = await client.get(f"{path}/situation")
    assert reply.status_code == 200, reply.text
    return reply.json()


async def until(client, path, holds):
    async with asyncio.timeout(HANGS_S):
        while not holds(found := await guide(client, path)):
            await asyncio.sleep(0.005)
        return found


async def begun(client, **changes):
    path = await planned(client, **{"n": 4} | changes)
    await pressed(client, path, "start")
    await pressed(client, path, "confirm")
    return path


async def halted(client, bench, after, **changes):
    """A session that was paused on the way to the stop behind the first `after` ones."""
    path = await planned(client, **{"n": 4} | changes)
    await pressed(client, path, "start")
    bench.robot.gate.clear()
    await pressed(client, path, "confirm")
    for _ in range(2 * after):  # approach and stop
        bench.robot.sent.clear()
        bench.robot.gate.set()
        await bench.robot.sent.wait()
        bench.robot.gate.clear()
    await until(client, path, lambda found: found["progress"]["done"] >= after)
    await pressed(client, path, "pause")
    bench.robot.gate.set()
    await until(client, path, lambda found: found["state"] == "paused")
    return path


async def finished(client, path):
    return await until(client, path, lambda found: found["state"] == "finished")


async def test_a_planned_session_says_what_it_is_and_what_may_be_pressed(client):
    found = await guide(client, await planned(client, n=4, warm_up=True))

    assert (found["kind"], found["state"], found["warm_up"]) == ("tracker", "planned", True)
    assert found["commands"] == ["abort", "start"]
    assert found["step"] == {"id": "instruments", "kind": "instruments", "config": None, "nest": None}


async def test_start_asks_and_confirm_moves(client, bench):
    path = await planned(client, n=4)

    asked = await pressed(client, path, "start")

    assert asked["session"]["state"] == "awaiting_confirmation"
    assert asked["sentence"] == asked["session"]["prompt"]["message"]
    assert bench.robot.moves == 0
    await pressed(client, path, "confirm", prompt_id=asked["session"]["prompt"]["id"])
    assert (await finished(client, path))["progress"]["done"] == 4


def told_s(reply):
    return float(reply.headers["Truepose-Time"])


async def test_a_tap_that_was_long_under_way_lets_nothing_move(client, bench):
    path = await planned(client, n=4)
    asked = await press(client, path, "start")

    late = await press(client, path, "confirm", "k1", pressed_at_s=told_s(asked) - 10)
    bare = path
    body = {"person": "Ada Byron", "pressed_at_s": told_s(asked) - 10}
    elsewhere = await command(client, bare, "confirm", **body)

    for refused in (late, elsewhere):
        assert refused.status_code == 409
        assert "pressed too long ago" in refused.json()["detail"]
    assert bench.robot.moves == 0
    await pressed(client, path, "confirm", "k2", pressed_at_s=told_s(late))
    assert (await finished(client, path))["progress"]["done"] == 4


async def test_what_halts_is_never_too_old(client):
    path = await planned(client, n=4)
    asked = await press(client, path, "start")

    await pressed(client, path, "abort", pressed_at_s=max(0.0, told_s(asked) - 3600))

    assert (await guide(client, path))["state"] == "aborted"


@pytest.mark.parametrize("act", ["start", "confirm"])
async def test_an_act_that_arrives_again_is_done_once(client, bench, act):
    path = await planned(client, n=4)
    if act == "confirm":
        await pressed(client, path, "start")

    asked = {"prompt_id": prompt_id(await guide(client, path))}
    first = await pressed(client, path, act, key="same", **asked)
    again = await pressed(client, path, act, key="same", **asked)

    assert (first["sentence"], first["entry"]) == (again["sentence"], again["entry"])


async def test_the_sheet_tells_nominal_actual_and_delta(client):
    path = await begun(client, n=3)
    await finished(client, path)

    sheet = (await client.get(f"{path}/sheet")).json()

    assert [row["status"] for row in sheet["points"]] == ["measured"] * 3
    for row in sheet["points"]:
        assert row["delta_mm"] == pytest.approx([0.0] * 3, abs=1e-5)  # the bench measures what it aims at
        assert row["distance_mm"] <= 1e-5
        assert row["rms_mm"] <= row["rms_limit_mm"]
        assert row["readings"] == 1
    assert [nest["readings"] for nest in sheet["nests"]] == [2, 2, 2]
    assert all(look["holds"] for look in sheet["looks"])
    assert len(sheet["looks"]) == 2  # before the first and after the last
    assert sheet["warmth"] is None


async def test_before_anything_is_read_the_sheet_is_empty_and_not_filled_in(client):
    path = await planned(client, n=4, warm_up=True)

    sheet = (await client.get(f"{path}/sheet")).json()

    assert sheet["warmth"]["ready"] is False
    assert sheet["warmth"]["time_s"] == []
    assert sheet["placed"] is None
    assert [(nest["readings"], nest["delta_mm"]) for nest in sheet["nests"]] == [(0, None)] * 3
    assert {(row["status"], row["actual_mm"], row["readings"]) for row in sheet["points"]} == {
        ("open", None, 0)
    }


async def test_what_is_left_out_counts_no_more_and_what_is_wanted_again_comes_after_a_question(client, bench):
    path = await halted(client, bench, 2)

    left_out = await pressed(client, path, "skip", step_id="stop-1", reason="The reflector was touched.")
    again = await pressed(client, path, "retry", step_id="stop-2")

    assert left_out["sentence"] == "Configuration 1 is skipped."
    assert left_out["session"]["progress"]["skipped"] == 1
    assert "after a person has confirmed" in again["sentence"]
    readings = f"{path}/readings?kind=point&superseded=false"
    assert (await client.get(readings)).json() == []
    await pressed(client, path, "resume")
    asked = await until(client, path, lambda found: found["state"] == "awaiting_confirmation")
    assert asked["prompt"]["leads_to"] == [2]
    await pressed(client, path, "confirm", key="once-more")
    await finished(client, path)
    rows = {row["config"]: row for row in (await client.get(f"{path}/sheet")).json()["points"]}
    assert (rows[1]["status"], rows[1]["reason"]) == ("left_out", "The reflector was touched.")
    assert (rows[2]["status"], rows[2]["readings"]) == ("measured", 2)
    counted = (await client.get(readings)).json()
    assert sorted(reading["point"]["config"] for reading in counted) == [2, 3, 4]


async def test_a_skip_needs_its_reason(client, bench):
    path = await halted(client, bench, 1)

    refused = await press(client, path, "skip", step_id="stop-3")

    assert refused.status_code == 422
    assert "reason" in refused.json()["detail"]


async def test_stop_has_a_person_confirm_anew(client, bench):
    path = await planned(client, n=4)
    await pressed(client, path, "start")
    bench.robot.gate.clear()
    await pressed(client, path, "confirm")
    await bench.robot.sent.wait()

    await pressed(client, path, "stop")
    bench.robot.gate.set()

    stopped = await until(client, path, lambda found: found["state"] == "awaiting_confirmation")
    assert stopped["prompt"]["message"].startswith("Stop was pressed.")


async def test_the_scene_says_what_is_seen(client):
    path = await planned(client, n=4)

    scene = (await client.get(f"{path}/scene")).json()

    assert [nest["name"] for nest in scene["fixed_nests"]] == ["F1", "F2", "F3"]
    assert [stop["config"] for stop in scene["stops"]] == [1, 2, 3, 4]
    assert scene["instrument_mm"] == [2600.0, -700.0, 500.0]
    assert scene["placed"] is False
    assert len(scene["arm_mm"]) >= 6


async def test_too_few_readings_promise_nothing(client):
    path = await begun(client, n=3)
    await finished(client, path)

    assert (await client.get(f"{path}/outlook")).json() == {"state": "too_early", "now": None, "at_end": None}


class TestOutlook:
    asked = 0

    @pytest.fixture
    def worker(self):
        async def answer(task, told):
            self.asked += 1
            here = ExpectedAccuracy(len(task.session.points), 0.12, 0.3)
            return SessionForecast(here, here)

        return answer

    async def test_a_worker_says_what_the_readings_promise_once_for_all_tablets(self, client):
        path = await begun(client, n=12)
        await finished(client, path)

        found = [(await client.get(f"{path}/outlook")).json() for _ in range(3)]

        assert found[0]["now"] == {"configurations": 12, "mean_mm": 0.12, "worst_mm": 0.3}
        assert self.asked == 1


async def test_a_session_with_the_ballbar_is_guided_elsewhere(client, bench):
    assert (await client.get("/api/v1/sessions/77/situation")).status_code == 404


async def test_the_stream_begins_with_the_session(client):
    path = await planned(client, n=4)

    text = (await client.get(f"{path}/live?tablet=t1&stop_after_s=0.2")).text

    situations = [line for line in text.splitlines() if line.startswith("data: ")]
    assert json.loads(situations[0].removeprefix("data: "))["watching"] == 1
