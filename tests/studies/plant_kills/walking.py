"""A person at a tablet who walks through one ballbar session after the other while the service is killed."""

import asyncio
import contextlib
import itertools
from typing import Final

import httpx

from tests.studies.plant_kills.delivering import Acknowledged
from truepose.demo.simulated_operator import SimulatedOperator

_ANSWER_S: Final = 300.0
_AGAIN_S: Final = 0.2
_PLACE: Final = {
    "x_mm": 360.0,
    "y_mm": -463.0,
    "z_mm": 362.0,
    "rx_deg": -49.4,
    "ry_deg": -29.8,
    "rz_deg": 80.3,
}


async def walk_sessions(
    cell: str, url: str, acknowledged: Acknowledged, seed: int, ended: asyncio.Event, unharmed: asyncio.Lock
) -> None:
    """Walk until that is ended; the service lives as long as it chooses the poses of a session."""
    async with httpx.AsyncClient(base_url=url, timeout=_ANSWER_S, trust_env=False) as http:
        for number in itertools.count():
            if ended.is_set():
                return
            session = await _begun(http, seed + number, unharmed)
            if session is not None:
                await _walked(http, session, f"tablet-{seed}-{number}", cell, acknowledged, ended)


async def _begun(http: httpx.AsyncClient, seed: int, unharmed: asyncio.Lock) -> int | None:
    wanted = {"name": "killed", "seed": seed, "poses": 4, "placements": [_PLACE]}
    async with unharmed:
        try:
            created = await http.post("/api/v1/sessions", json={"kind": "ballbar", **wanted})
        except httpx.TransportError:
            await asyncio.sleep(_AGAIN_S)
            return None
    if created.status_code == httpx.codes.SERVICE_UNAVAILABLE:
        return None
    created.raise_for_status()
    return int(created.json()["id"])


async def _walked(
    http: httpx.AsyncClient,
    session: int,
    tablet: str,
    cell: str,
    acknowledged: Acknowledged,
    ended: asyncio.Event,
) -> None:
    person = SimulatedOperator(http, session, tablet)
    walking = asyncio.create_task(person.walk())
    ending = asyncio.create_task(ended.wait())
    await asyncio.wait({walking, ending}, return_when=asyncio.FIRST_COMPLETED)
    for task in (walking, ending):
        task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await walking
    await person.act("abort")
    for act in person.ledger.acts:
        if act.entry is not None:
            acknowledged.note(cell=cell, session=session, act=act.key)
