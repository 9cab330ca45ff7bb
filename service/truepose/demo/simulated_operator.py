"""A person at the tablet of a simulated cell, over REST like any tablet, with a ledger of their own.

They do with the simulated hands what the page asks, press the button, and write down what was acknowledged.
A request that gets no answer, or none but that it cannot be done now (503), is repeated with the same key.
"""

import asyncio
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

import httpx

from truepose.demo.errors import RequestRefusedError, ServiceFailedError

_API: Final = "/api/v1"
_ANSWERS: Final = {"confirm", "resume"}  # to the question that is open, where one is
_PERSON: Final = "demo"
_AGAIN_S: Final = 0.1  # between two attempts to reach a service that does not answer
_PATIENCE_S: Final = 90.0  # until a service that was killed is there again, on a busy machine
_TRIES: Final = 400  # to have a length stored before its step is skipped
_ADVICE: Final = "Skip as out of range"  # where two balls are too close together or too far apart
_ADVISED: Final = 20  # times, until it is followed
_LOOK_S: Final = 0.02
_UNREADABLE: Final = "The length is out of range."
_OFF: Final = "It lies beside the arm."  # kept where it was not seen to come off
Session: TypeAlias = dict[str, Any]  # as the service shows it


def number_of_prompt(session: Session) -> int | None:
    """Return the number of what a session asks, as an answer names it; None where it asks nothing."""
    return None if session["prompt"] is None else int(session["prompt"]["id"])


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """An act whose answer came."""

    key: str
    step_id: str | None
    act: str
    entry: int | None
    sentence: str


@dataclass(slots=True)
class OwnLedger:
    """What the person knows to be kept."""

    acts: list[Acknowledgement] = field(default_factory=list)
    repeated: int = 0  # requests that were sent more than once


def present_step(session: Session) -> str | None:
    """Return the id of the present step; None where there is none."""
    return None if session["step"] is None else str(session["step"]["id"])


class SimulatedOperator:
    """Walks through one ballbar session."""

    def __init__(self, http: httpx.AsyncClient, session_id: int, tablet: str = "tablet-1") -> None:
        self._http = http
        self._id = session_id
        self._tablet = tablet
        self._keys: Iterator[int] = itertools.count(1)
        self.ledger = OwnLedger()
        self.refusals: list[str] = []  # what the hands could not do, in the cell's words
        self.seen: Session | None = None  # the session as it was last told
        self.hands_free = asyncio.Event()  # cleared: the person waits and sends nothing
        self.hands_free.set()

    @property
    def path(self) -> str:
        """Where the session is."""
        return f"{_API}/sessions/{self._id}"

    async def walk(self, until: str | None = None) -> Session:
        """Go through the session to its end, or until the step named `until` is the present one."""
        return await self.walk_until(lambda session: until is not None and present_step(session) == until)

    async def walk_until(self, reached: Callable[[Session], bool]) -> Session:
        """Go through the session to its end, or until what it shows is what was to be reached."""
        while True:
            session = await self.session()
            if session["state"] in {"finished", "aborted", "failed"} or reached(session):
                return session
            await self._go_on(session)

    async def session(self) -> Session:
        """Return the session as the service has it."""
        answer = await self._reach("GET", f"/sessions/{self._id}/situation")
        found: Session = answer.json()
        self.seen = found
        return found

    async def act(self, name: str, step_id: str | None = None, **said: str) -> httpx.Response:
        """Press a button; returns the answer, which may be a refusal."""
        key = f"{self._tablet}-{next(self._keys)}"
        body: dict[str, str | int | None] = {"command": name, "step_id": step_id, **said}
        body |= {"person": _PERSON, "tablet": self._tablet}
        if name in _ANSWERS:
            body["prompt_id"] = number_of_prompt(await self.session())
        answer = await self._reach("POST", f"/sessions/{self._id}/commands", body, key)
        if answer.is_success:
            told = answer.json()
            self.ledger.acts.append(Acknowledgement(key, step_id, name, told["entry"], told["sentence"]))
            self.seen = told["session"]
        return answer

    async def hands(self, action: str, **details: Any) -> httpx.Response:
        """Have the simulated hands do something; returns the answer, which may be a refusal."""
        answer = await self._reach("POST", "/simulated-hands", {"action": action, **details})
        if answer.status_code == httpx.codes.CONFLICT:
            self.refusals.append(answer.json()["detail"])
        return answer

    async def _go_on(self, session: Session) -> None:
        state, step = session["state"], session["step"]
        if state == "paused" and step is not None and step["kind"] == "precalibrate":
            await self.act("skip", step["id"], reason=session["reason"])
        elif state in {"planned", "paused", "awaiting_confirmation"}:
            await self.act({"planned": "start", "paused": "resume"}.get(state, "confirm"))
        elif state != "running" or step is None or session["robot_moving"] or step["kind"] == "precalibrate":
            await asyncio.sleep(_LOOK_S)
        elif session["suspicion"] is not None:
            await self.act("answer", step["id"], answer="right_pair")
        elif step["kind"] in {"initialise", "measure_side", "connect_leg"}:
            await self._read(step)
        else:
            await self._do(step)

    async def _do(self, step: dict[str, Any]) -> None:
        """Do by hand what a step asks for, and confirm it."""
        match step["kind"]:
            case "place_base":
                await self.hands("place_base", placement=step["placement"])
            case "clamp_cup":
                await self.hands("clamp", base_point=step["base_point"])
            case "fit_ball":
                await self.hands("fit_ball")
            case "remove_ball":
                await self.hands("remove_ball")
            case "detach":
                await self.hands("detach")
        known = {"reason": _OFF} if step["kind"] in {"detach", "move"} else {}
        if (await self.act("confirm", step["id"], **known)).is_error:
            await asyncio.sleep(_LOOK_S)

    async def _read(self, step: dict[str, Any]) -> None:
        """Attach the ballbar and press the button until the length is kept."""
        await self._attach(step)
        advised = 0
        for _ in range(_TRIES):
            session = await self.session()
            if session["step"] is None or session["step"]["id"] != step["id"] or session["suspicion"]:
                return
            if session["state"] != "running":
                return
            answer = await self.act("store", step["id"])
            if answer.is_success:
                return
            advised += _ADVICE in answer.text
            if advised == _ADVISED:
                break
            await asyncio.sleep(_LOOK_S)
        (await self.act("skip", step["id"], reason=_UNREADABLE)).raise_for_status()

    async def _attach(self, step: dict[str, Any]) -> None:
        if step["kind"] == "initialise":
            await self.hands("calibrator", bars=step["artefact"])
            return
        first, second = (int(name[1:]) for name in step["points"])
        if step["kind"] == "connect_leg":
            await self.hands("connect", base=first, tool=second)
        else:
            await self.hands("side", artefact=step["artefact"], a=first, b=second)

    async def _reach(
        self, method: str, path: str, body: dict[str, Any] | None = None, key: str | None = None
    ) -> httpx.Response:
        """Send a request until it is answered; raises ServiceFailedError after a minute and a half."""
        deadline = asyncio.get_running_loop().time() + _PATIENCE_S
        sent = 0
        while asyncio.get_running_loop().time() < deadline:
            await self.hands_free.wait()
            sent += 1
            answer = await self._send(method, path, body, key)
            if answer is None:
                await asyncio.sleep(_AGAIN_S)
                continue
            self.ledger.repeated += key is not None and sent > 1
            if answer.status_code in {httpx.codes.NOT_FOUND, httpx.codes.UNPROCESSABLE_ENTITY}:
                raise RequestRefusedError(f"The service refused {method} {path}: {answer.text}")
            return answer
        raise ServiceFailedError(f"The service stopped responding to {method} {path}; see its log.")

    async def _send(
        self, method: str, path: str, body: dict[str, Any] | None, key: str | None
    ) -> httpx.Response | None:
        """Send a request once; None where it has no answer, or none but that it cannot be done for now."""
        headers = {} if key is None else {"Idempotency-Key": key}
        try:
            answer = await self._http.request(method, f"{_API}{path}", json=body, headers=headers)
        except httpx.TransportError:
            return None
        return None if answer.status_code == httpx.codes.SERVICE_UNAVAILABLE else answer
