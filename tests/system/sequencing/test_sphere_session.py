"""A sphere test as a session on a simulated cell, over REST: planned, measured, judged."""

import hashlib

import httpx
import pytest

from tests.studies.interruptions.ballbar_person import PersonAtTablet
from tests.studies.interruptions.killed_service import KilledService, standing_cell
from truepose.reports.rounding import rounded

_PLACE = {"x_mm": 350, "y_mm": -150, "z_mm": 150, "ry_deg": -30, "rz_deg": 60}
_WANTED = {
    "name": "sphere",
    "placements": [_PLACE],
    "plan": {"method": "sphere", "configurations": 7, "nests": [1]},
}


@pytest.fixture
async def service(tmp_path):
    async with standing_cell("irb120-everyday", 2, 0, tmp_path / "cell.log") as cell_file:
        (tmp_path / "cell.toml").write_text(cell_file, encoding="utf-8")
        service = KilledService(
            tmp_path / "cell.toml", tmp_path / "sessions.sqlite3", tmp_path / "service.log"
        )
        await service.start()
        async with httpx.AsyncClient(base_url=service.url, timeout=200.0, trust_env=False) as client:
            yield client
        await service.kill()


async def test_what_a_session_read_is_judged_about_the_ball_that_the_arm_held(service):
    created = await service.post("/api/v1/ballbar-sessions", json=_WANTED)
    assert created.status_code == 201, created.text
    number = created.json()["id"]
    assert (await service.get(f"/api/v1/sessions/{number}/sphere")).status_code == 409  # nothing is read yet
    person = PersonAtTablet(service, number)

    session = await person.walk()

    assert session["state"] == "finished", session["reason"]
    told = await service.get(f"/api/v1/sessions/{number}/sphere")
    test = told.json()
    (ball,) = test["spheres"]
    steps = (await service.get(f"{person.path}/steps")).json()["steps"]
    measured = [step["id"] for step in steps if "/leg-1-1" in step["id"] and step["outcome"] == "measured"]
    assert len(ball["config"]) == len(measured) >= 6
    assert [(one["model"], one["centre"]) for one in ball["errors"]] == [
        ("nominal", "taught"),
        ("nominal", "best"),
    ]
    # Lengths near 300 mm of an arm whose errors are some tenths: targets of the nominal arm.
    assert ball["errors"][0]["error_mm"] == pytest.approx(ball["shown_mm"], abs=1e-6)
    assert not ball["errors"][0]["noise_alone"]

    assert session["result_url"] == f"/sessions/{number}/result"
    page = (await service.get(session["result_url"])).text
    for one in ball["errors"]:
        mean = one["figures"][0]["mean_mm"]
        assert f'<td class="n">{rounded(mean["value"], mean["standard_uncertainty"])}</td>' in page
    assert hashlib.sha256(told.content).hexdigest() in page
    assert f'href="/sessions/{number}/result"' in (await service.get("/sessions")).text
