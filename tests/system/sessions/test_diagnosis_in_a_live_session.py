"""An effect that begins in the middle of a session is found by the product, over REST, with real numerics."""

from pathlib import Path

import pytest

import truepose.exchange
from tests.helpers.web.clients import command, made, served, until
from truepose.settings import Settings

# A clean robot whose base is pushed when about half of the configurations are measured: they take from 580 s
# to 1,850 s of cell time. Readings scatter by 0.03 mm, so a push by 0.3 mm is plain.
PUSHED_AT_S = 1200.0
PUSH_MM = 0.3
PUSH = f"""
[simulated]
scenario = "irb120-clean"
seed = 5

[[effect]]
name = "base_shift"
subject = "base"
amplitude = {PUSH_MM}
from_s = {PUSHED_AT_S}
"""
SHIPPED = Path(truepose.exchange.__file__).parent / "cells" / "simulated.toml"
SESSION = {
    "name": "pushed",
    "role": "calibration",
    "plan": {"method": "choose", "configurations": 60, "seed": 1},
    "registration_readings": 3,
}


async def confirmed(client, path):
    await until(client, path, lambda session: session["state"] == "awaiting_confirmation")
    await command(client, path, "confirm")


async def diagnosed(client, path):
    found = await made(client, await client.post(f"{path}/diagnosis", json={}))
    return (await client.get(found)).json()


def push_in(diagnosis):
    return next((f for f in diagnosis["document"]["findings"] if f["effect"] == "base_shift"), None)


@pytest.fixture
async def service_of_a_pushed_cell(tmp_path):
    file = tmp_path / "cell.toml"
    file.write_text(f'robot = "abb-irb-120"\n{SHIPPED.read_text()}{PUSH}')
    url = f"sqlite:///{tmp_path}/truepose.sqlite3"
    async with served(Settings(url, cell_file=file, simulated_pace=0)) as client:
        yield client


async def test_a_push_in_the_middle_of_a_session_is_found_with_its_size_and_moment(service_of_a_pushed_cell):
    client = service_of_a_pushed_cell
    path = await made(client, await client.post("/api/v1/sessions", json=SESSION))
    await command(client, path, "start")
    await confirmed(client, path)
    await until(client, path, lambda session: session["measured"] >= 15)
    await command(client, path, "pause")
    await until(client, path, lambda session: session["state"] == "paused")
    before = await diagnosed(client, path)
    await command(client, path, "resume")
    await until(client, path, lambda session: session["state"] == "finished")
    after = await diagnosed(client, path)

    push = push_in(after)
    moment = next(detail for detail in push["details"] if detail["name"] == "time")
    model = (await client.get(f"/api/v1/models/{after['model_id']}/file")).json()
    assert push_in(before) is None
    assert after["document"]["verdict"] == "explained"
    assert push["amplitude"] == pytest.approx(PUSH_MM, abs=4 * push["amplitude_standard_uncertainty"])
    # A configuration takes 17 s and fixed nests are looked at now and then: the gap it fell into is known.
    assert moment["value"] == pytest.approx(PUSHED_AT_S, abs=60.0)
    assert push["gain"]["rms_after_mm"] < push["gain"]["rms_before_mm"]
    assert "base_shift" in model["effects"]
