"""What a run asks of the service, over REST like any client, and how it looks after a session."""

import asyncio
import contextlib
import json
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import httpx

from truepose.demo.errors import JobFailedError, RequestRefusedError, ServiceFailedError, SessionHaltedError
from truepose.demo.simulated_operator import SimulatedOperator, number_of_prompt

PERSON: Final = "demo"  # who confirms that a simulated cell is clear of people
Told = Callable[[int, int, str], None]  # how many are done, of how many, what is being done

_API: Final = "/api/v1"
_ENDED_SESSION: Final = {"finished", "aborted", "failed"}
# A person would look at the cell now; this run has none.
_STANDING_STILL: Final = {"paused", "awaiting_confirmation", "aborted", "failed"}
_ENDED_JOB: Final = {"succeeded", "failed", "cancelled", "interrupted"}
_ANSWER_S: Final = 60.0  # a page of a thousand readings takes a tenth of a second on an idle machine
_PERCENT: Final = 100
_PAGE: Final = 500


@contextlib.asynccontextmanager
async def open_client(url: str) -> AsyncIterator["ServiceClient"]:
    """Open a client; raises ServiceFailedError where the service stops answering in the meantime."""
    try:
        # trust_env off: a proxy for the world's traffic has nothing to do with loopback.
        async with httpx.AsyncClient(base_url=url, timeout=_ANSWER_S, trust_env=False) as http:
            yield ServiceClient(http)
    except httpx.TransportError as error:
        raise ServiceFailedError(
            f"The service at {url} stopped responding ({type(error).__name__}); see its log."
        ) from error


def _nobody(done: int, planned: int, doing: str) -> None:
    """Tell nobody how far a job is."""


class ServiceClient:
    """The requests of a demo run; each raises RequestRefusedError with the service's own sentence."""

    def __init__(self, http: httpx.AsyncClient) -> None:
        self._http = http

    async def get(self, path: str) -> Any:
        """Return what is at `path`, below the versioned API."""
        return (await self._send("GET", path)).json()

    async def download(self, path: str) -> bytes:
        """Return the file at `path`."""
        return (await self._send("GET", path)).content

    async def end_left_sessions(self) -> None:
        """End the sessions that an interrupted run left in the database; their readings stay."""
        for session in await self._whole("/sessions"):
            if session["state"] not in {*_ENDED_SESSION, "planned"}:
                await self._command(session["id"], "abort")

    async def connect_devices(self) -> None:
        """Connect every device of the cell, which makes each say who it is."""
        for device in await self.get("/devices"):
            await self._post(f"/devices/{device['name']}/connect", None)

    async def plan(self, name: str, role: str, configurations: int, seed: int) -> int:
        """Have configurations chosen by a job; returns the job's number."""
        chosen = {"method": "choose", "configurations": configurations, "seed": seed}
        job = await self._post("/sessions", {"name": name, "role": role, "plan": chosen})
        return int(job["id"])

    async def identify(self, campaign_id: int) -> int:
        """Queue an identification; returns the job's number."""
        return int((await self._post("/identifications", {"campaign_id": campaign_id}))["id"])

    async def validate(self, model_id: int, campaign_id: int, limit_mm: float | None) -> int:
        """Queue a validation; returns the job's number."""
        request = {"model_id": model_id, "campaign_id": campaign_id, "limit_mm": limit_mm}
        return int((await self._post("/validations", request))["id"])

    async def diagnose(self, campaign_id: int) -> int:
        """Queue a diagnosis; returns the job's number."""
        return int((await self._post("/diagnoses", {"campaign_id": campaign_id}))["id"])

    async def plan_ballbar(self, name: str, poses: int, seed: int) -> int:
        """Plan a ballbar session; returns its number."""
        wanted = {"kind": "ballbar", "name": name, "poses": poses, "seed": seed}
        return int((await self._post("/sessions", wanted))["id"])

    async def plan_contacts(self, wanted: dict[str, Any]) -> int:
        """Plan a session of a closed loop; returns its number."""
        return int((await self._post("/sessions", {"kind": "contact", **wanted}))["id"])

    def person_at(self, session_id: int) -> SimulatedOperator:
        """Return somebody who goes through a ballbar session with the simulated hands."""
        return SimulatedOperator(self._http, session_id)

    async def campaign_of(self, name: str, session_ids: Sequence[int]) -> int:
        """Make a campaign of a session and, if there is one, of the session that judges it; its number."""
        request = {"name": name, "session_ids": list(session_ids)}
        return int((await self._post("/campaigns", request))["id"])

    async def make_campaign(self, name: str, calibration_id: int, validation_id: int) -> int:
        """Make a campaign of two sessions; returns its number."""
        request = {"name": name, "validation_session_id": validation_id}
        return int((await self._post(f"/sessions/{calibration_id}/campaign", request))["id"])

    async def finish_job(self, job_id: int, told: Told = _nobody) -> int:
        """Follow a job to its end and return the number of what it made; raises JobFailedError."""
        async with contextlib.aclosing(self._events(job_id=job_id)) as events:
            async for kind, event in events:
                if kind == "job.progress":
                    told(round(_PERCENT * event["fraction"]), _PERCENT, event["doing"])
                elif kind == "job.state" and event["state"] in _ENDED_JOB:
                    return _made(job_id, event, told)
        raise ServiceFailedError(
            f"The service closed its event stream before job {job_id} ended; see its log."
        )

    async def result_of(self, job_id: int, kind: str, told: Told) -> dict[str, Any]:
        """Follow a job to its end and return its record, one of `kind`; raises JobFailedError."""
        made: dict[str, Any] = await self.get(f"/{kind}/{await self.finish_job(job_id, told)}")
        return made

    async def run_session(self, session_id: int, told: Told) -> None:
        """Start a session, confirm it as a person would, and follow it; raises SessionHaltedError."""
        await self.begin(session_id)
        await self.confirm(session_id)
        moved = False
        async with contextlib.aclosing(self._events(session_id=session_id)) as events:
            async for kind, event in events:
                if kind == "session.progress":
                    told(event["done"] + event["skipped"], event["planned"], event["doing"])
                elif kind == "session.state":
                    if event["state"] == "finished":
                        return
                    if moved and event["state"] in _STANDING_STILL:
                        raise SessionHaltedError(
                            f"Session {session_id} is {_words(event['state'])}: {event['reason']}"
                        )
                    moved = moved or event["state"] == "running"
        raise ServiceFailedError(f"The service closed its event stream before session {session_id} ended.")

    async def begin(self, session_id: int) -> None:
        """Ask for a session to start; it then waits for a person."""
        await self._command(session_id, "start")

    async def resume(self, session_id: int) -> None:
        """Go on with a paused session, as a person who looked at the cell."""
        await self._command(session_id, "resume")

    async def confirm(self, session_id: int) -> None:
        """Say as a person that the cell is clear: the arm may move."""
        await self._command(session_id, "confirm")

    async def _command(self, session_id: int, command: str) -> None:
        path = f"/sessions/{session_id}"
        asked = number_of_prompt(await self.get(f"{path}/situation"))
        await self._post(f"{path}/commands", {"command": command, "person": PERSON, "prompt_id": asked})

    async def readings(self, session_id: int) -> list[dict[str, Any]]:
        """Return every reading of a session, those that no longer count included."""
        return await self._whole(f"/sessions/{session_id}/readings")

    async def _whole(self, path: str) -> list[dict[str, Any]]:
        """Return all records of a list, page by page."""
        found: list[dict[str, Any]] = []
        while True:
            after = found[-1]["id"] if found else 0
            page = await self.get(f"{path}?after={after}&limit={_PAGE}")
            found += page
            if len(page) < _PAGE:
                return found

    async def _events(self, **interest: int) -> AsyncGenerator[tuple[str, dict[str, Any]], None]:
        """Yield kind and document of every event of a session or a job, from its first on."""
        kind = ""
        async with self._http.stream("GET", f"{_API}/events", params=interest) as stream:
            async for line in stream.aiter_lines():
                field, _, value = line.partition(": ")
                if field == "event":
                    kind = value
                elif field == "data":
                    yield kind, json.loads(value)

    async def _post(self, path: str, body: dict[str, Any] | None) -> Any:
        return (await self._send("POST", path, body)).json()

    async def _send(self, method: str, path: str, body: dict[str, Any] | None = None) -> httpx.Response:
        answer = await self._http.request(method, f"{_API}{path}", json=body)
        if answer.is_error:
            raise RequestRefusedError(f"The service refused {method} {path}: {_reason(answer)}")
        return answer


def _reason(answer: httpx.Response) -> str:
    try:
        return str(answer.json()["detail"])
    except (ValueError, KeyError, TypeError):
        return f"status {answer.status_code}."


def _made(job_id: int, event: dict[str, Any], told: Told) -> int:
    if event["state"] != "succeeded" or event["result_id"] is None:
        raise JobFailedError(f"Job {job_id} {_words(event['state'])}: {event['message']}")
    told(_PERCENT, _PERCENT, event["message"])
    return int(event["result_id"])


def _words(state: str) -> str:
    return state.replace("_", " ")


_LOOK_S: Final = 0.05
_MOST_RESUMED: Final = 50  # far more than a night's faults; a session that needs more will never end
_FAILED: Final = frozenset({"aborted", "failed"})


@dataclass(slots=True)
class Attendance:
    """What somebody saw who looked after a session."""

    reasons: list[str] = field(default_factory=list)  # why it stood, in its own words
    session: dict[str, Any] = field(default_factory=dict)  # as the service showed it last

    @property
    def finished(self) -> bool:
        """Whether everything planned was measured or left out with a reason."""
        return self.session.get("state") == "finished"


async def attend(
    client: ServiceClient, session_id: int, enough: Callable[[int], bool] = lambda measured: False
) -> Attendance:
    """Bring a session to its end, or until `enough` configurations are measured.

    Raises
    ------
    SessionHaltedError
        It failed, or stands again and again.
    """
    seen = Attendance()
    while True:
        seen.session = await client.get(f"/sessions/{session_id}")
        if seen.finished or enough(int(seen.session["measured"])):
            return seen
        await _help(client, seen)
        await asyncio.sleep(_LOOK_S)


async def _help(client: ServiceClient, seen: Attendance) -> None:
    session_id, state = int(seen.session["id"]), str(seen.session["state"])
    if state in _FAILED or len(seen.reasons) > _MOST_RESUMED:
        raise SessionHaltedError(f"Session {session_id} is {state}: {seen.session['reason']}")
    if state in {"paused", "awaiting_confirmation"}:
        seen.reasons.append(str(seen.session["reason"]))
        await (client.resume if state == "paused" else client.confirm)(session_id)
