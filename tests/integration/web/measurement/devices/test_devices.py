"""Cells, devices, robots and health over REST."""

from truepose.storage.engine.schema import newest_revision


async def test_health_says_version_schema_and_whether_all_is_simulated(client):
    health = (await client.get("/health")).json()

    assert (health["status"], health["simulated"], health["schema"]) == ("ok", False, newest_revision())


async def test_a_connected_device_tells_who_it_is(client):
    before = (await client.get("/api/v1/devices/tracker")).json()
    connected = (await client.post("/api/v1/devices/tracker/connect")).json()

    assert (before["connected"], before["model"]) == (False, None)
    assert (connected["connected"], connected["manufacturer"], connected["model"]) == (True, "ACME", "T1")
    assert connected["certificate"] == "report 7"


async def test_a_device_that_does_not_answer_is_a_problem_with_the_drivers_sentence(client, bench):
    bench.tracker.dead = True

    refused = await client.post("/api/v1/devices/tracker/connect")
    state = (await client.get("/api/v1/devices/tracker")).json()

    assert refused.status_code == 503
    assert refused.headers["content-type"] == "application/problem+json"
    assert refused.json()["detail"].startswith("Nobody answers at 192.0.2.1:700")
    assert state["fault"] == refused.json()["detail"]


async def test_a_driver_that_fails_is_a_problem_with_its_name_and_no_traceback(client, bench):
    async def stumble():
        raise ValueError("The device has no langid (permission issue or device error)")

    bench.tracker.identify = stumble

    refused = await client.post("/api/v1/devices/tracker/connect")

    assert refused.status_code == 503
    assert refused.headers["content-type"] == "application/problem+json"
    assert "driver fake_tracker failed in identify" in refused.json()["detail"]
    assert "cable" in refused.json()["detail"]


async def test_a_device_that_is_not_there_is_answered_with_those_that_are(client):
    refused = await client.get("/api/v1/devices/camera")

    assert refused.status_code == 404
    assert refused.json()["detail"] == "The cell has no device 'camera'; available devices: tracker, robot."


async def test_an_unknown_robot_is_answered_with_the_known_ones(client):
    refused = await client.get("/api/v1/robots/irb-9000")

    assert refused.status_code == 404
    assert "'irb-9000'" in refused.json()["detail"]
    assert "abb-irb-120" in refused.json()["detail"]


async def test_every_listed_robot_can_be_shown(client):
    for robot in (await client.get("/api/v1/robots")).json():
        shown = (await client.get(f"/api/v1/robots/{robot['name']}")).json()

        assert shown == robot
        assert [row["joint"] for row in shown["joints"]] == list(range(1, len(shown["joints"]) + 1))


async def test_the_cell_shows_its_nests_in_mm(client):
    (cell,) = (await client.get("/api/v1/cells")).json()

    assert (await client.get("/api/v1/cells/bench")).json() == cell
    assert cell["fixed_nests"][1] == {
        "nest": 2,
        "centre_mm": [600.0, 500.0, 0.0],
        "standard_uncertainty_mm": 0.002,
    }
    assert (await client.get("/api/v1/cells/other")).status_code == 404
