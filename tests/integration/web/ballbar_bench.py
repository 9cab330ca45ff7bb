"""A ballbar session on the bench: a plan that harms nobody, and a tablet that presses buttons."""

from tests.helpers.web.clients import ANSWERS, prompt_id
from tests.integration.web.bench import SESSIONS

BALLBAR = """
[ballbar]
base_points = 3

[[device]]
name = "ballbar"
driver = "fake_ballbar"

[[device]]
name = "hands"
driver = "fake_hands"
"""
PLACEMENT = {
    "x_mm": 350.0,
    "y_mm": 0.0,
    "z_mm": 50.0,
    "cups_mm": [[350.0, 0.0, 50.0], [650.0, 0.0, 50.0], [500.0, 260.0, 50.0]],
    "setups": [{"base_point": k, "joints_deg": [10.0 * k, 20, 10, 0, 30, 0]} for k in (1, 2, 3)],
    "poses": [
        {
            "config": k,
            "joints_deg": [5.0 * k, 20, 0, 0, 40, 0],
            "legs": [[1, 1], [1, 2], [2, 2], [2, 3], [3, 3], [3, 1]],
        }
        for k in (1, 2)
    ],
}
WANTED = {"kind": "ballbar", "name": "six legs", "placements": [PLACEMENT]}
# Good before the LR Mate. The service then chooses only poses: to look for a place takes ten seconds.
PLACE = {"x_mm": 360.0, "y_mm": -463.0, "z_mm": 362.0, "rx_deg": -49.4, "ry_deg": -29.8, "rz_deg": 80.3}


def with_ballbar(settings):
    """Return the settings of a service whose cell has a ballbar too."""
    with settings.cell_file.open("a") as cell_file:
        cell_file.write(BALLBAR)
    return settings


class Tablet:
    """Presses buttons, each with a key of its own unless one is given."""

    def __init__(self, client, name="tablet-1", session_id=1):
        self._client = client
        self._name = name
        self._keys = 0
        self.path = f"{SESSIONS}/{session_id}"

    async def press(self, act, key=None, **said):
        self._keys += 1
        body = {"command": act, "person": "Ada", "tablet": self._name, **said}
        if act in ANSWERS and "prompt_id" not in said:
            body["prompt_id"] = prompt_id(await self.see())
        key = key or f"{self._name}-{self._keys}"
        return await self._client.post(f"{self.path}/commands", json=body, headers={"Idempotency-Key": key})

    async def see(self):
        return (await self._client.get(f"{self.path}/situation")).json()

    async def ledger(self, **page):
        return (await self._client.get(f"{self.path}/ledger", params=page)).json()["entries"]
