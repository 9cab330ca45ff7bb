"""Sessions in space over REST: what was measured, what comes next, and the bars of a pose."""

import numpy as np
import pytest

from tests.integration.web.ballbar_bench import PLACEMENT, SESSIONS, WANTED, with_ballbar
from tests.integration.web.bench import measured, planned


class TestByTracker:
    """A session in which one nest is measured at a stop."""

    async def test_what_is_planned_is_to_come_and_the_first_comes_next(self, client):
        space = (await client.get(f"{await planned(client)}/space")).json()

        assert {stop["state"] for stop in space["stops"]} == {"to_come"}
        assert space["next_config"] == space["stops"][0]["config"]
        assert space["instrument_mm"] is None

    async def test_what_was_measured_says_so(self, client, until):
        path = await measured(client, until)

        space = (await client.get(f"{path}/space")).json()

        assert {stop["state"] for stop in space["stops"]} == {"measured"}
        assert space["next_config"] is None
        assert space["instrument_mm"] is not None

    async def test_a_session_that_is_not_there_has_no_space(self, client):
        assert (await client.get("/api/v1/sessions/9/space")).status_code == 404


class TestByBallbar:
    """A session in which a bar joins cups and nests."""

    @pytest.fixture
    def settings(self, settings):
        return with_ballbar(settings)

    async def test_each_pose_has_its_bars_between_cup_and_nest(self, client):
        number = (await client.post(SESSIONS, json=WANTED)).json()["id"]

        space = (await client.get(f"/api/v1/sessions/{number}/space")).json()

        pose = space["stops"][0]
        bars = np.array([
            piece for piece in pose["pieces_mm"] if piece[6] == 8.0 and piece[:3] in PLACEMENT["cups_mm"]
        ])
        assert [stop["config"] for stop in space["stops"]] == [1, 2]
        assert len(bars) == 6
        nests = {
            tuple(piece[3:6]) for piece in pose["pieces_mm"][-9:-6]
        }  # what leads from the flange to each
        assert {tuple(bar[3:6]) for bar in bars} == nests
