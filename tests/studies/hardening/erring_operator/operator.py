"""A person at the tablet who errs at every step: wrong pairs, the bar left on, early confirmations, reloads.

Every error is one that a hurried person makes with honest hands: the simulated cell decides whether the
hands can do it. What the person says to a question is mostly, not always, the truth.
"""

import asyncio
import itertools
import random
from collections import Counter
from typing import Any

import httpx

from tests.studies.taken_up.onlooked_cell import OnlookedCell
from truepose_simulators.faults.kinds import IdentityChanged

Session = dict[str, Any]
_API = "/api/v1"
_READS = {"initialise", "measure_side", "connect_leg"}
_ENDED = {"finished", "aborted", "failed"}
_LOOK_S = 0.02
_MEDDLING = (
    *("second tablet", "reload", "back", "pause", "stop", "retry", "skip", "cable", "bar"),
    *("another ballbar", "another robot"),
)
_TRIES = 5  # to have a length stored before the person thinks again


class ErringOperator:
    """Walks through a session and errs; `share` is how often, at each step."""

    def __init__(self, cell: OnlookedCell, rng: random.Random, share: float) -> None:
        self._cell = cell
        self._rng = rng
        self._share = share
        self._keys = itertools.count(1)
        self._tablet = "tablet-1"
        self._sent: list[tuple[str, dict[str, Any]]] = []
        self.http: httpx.AsyncClient | None = None
        self.session_id = 0
        self.errors: Counter[str] = Counter()
        self.acknowledged: dict[int, str] = {}  # line -> key
        self.broken: list[str] = []  # answers that no client may get
        self.foreign_since_s: float | None = None  # another ballbar is in the cell, and nobody accepted it

    def take_care(self) -> None:
        """Err no more."""
        self._share = 0.0

    # what the page does

    async def see(self) -> Session:
        """Return the session as the service has it."""
        answer = await self._send("GET", f"/sessions/{self.session_id}/situation")
        found: Session = answer.json()
        return found

    async def act(self, name: str, step_id: str | None = None, **said: str) -> httpx.Response:
        """Press a button."""
        key = f"{self._tablet}-{self._rng.getrandbits(64):x}"
        body = {"command": name, "step_id": step_id, "person": "Eva", "tablet": self._tablet, **said}
        if name in {"confirm", "resume"} and "prompt_id" not in said:
            body["prompt_id"] = ((await self.see()).get("prompt") or {}).get("id")
        self._sent.append((key, body))
        return await self._post_act(key, body)

    async def _post_act(self, key: str, body: dict[str, Any]) -> httpx.Response:
        path = f"/sessions/{self.session_id}/commands"
        answer = await self._send("POST", path, json=body, headers={"Idempotency-Key": key})
        if answer.is_success and answer.json()["entry"] is not None:
            self.acknowledged[int(answer.json()["entry"])] = key
        return answer

    async def _send(self, method: str, path: str, **how: Any) -> httpx.Response:
        if self.http is None:
            raise RuntimeError("nobody listens")
        answer = await self.http.request(method, f"{_API}{path}", **how)
        if answer.status_code >= httpx.codes.INTERNAL_SERVER_ERROR and answer.status_code != 503:
            self.broken.append(f"{method} {path}: {answer.status_code} {answer.text[:200]}")
        return answer

    def hands(self, action: str, **details: Any) -> bool:
        """Have the hands do something; returns whether it could be done."""
        try:
            self._cell.do(action, details)
        except Exception as error:
            if type(error).__name__ != "HandsError":
                raise
            return False
        return True

    # what the person does

    async def deed(self) -> bool:
        """Do the next thing, rightly or not; returns whether the session goes on."""
        session = await self.see()
        state, step = session["state"], session["step"]
        if state in _ENDED:
            return False
        if self._rng.random() < 0.1 * self._share:
            await self._meddle(session)
        elif state == "paused" and step is not None and step["kind"] == "precalibrate":
            await self.act("skip", step["id"], reason="not possible now")
        elif state in {"planned", "paused", "awaiting_confirmation"}:
            await self._go_on(session)
        elif step is None or session["robot_moving"] or step["kind"] == "precalibrate":
            await asyncio.sleep(_LOOK_S)
        elif session["suspicion"] is not None:
            await self._answer(session)
        elif step["kind"] in _READS:
            await self._read(session)
        else:
            await self._do(session)
        return True

    def _errs(self, what: str, odds: float = 1.0) -> bool:
        if self._rng.random() >= self._share * odds:
            return False
        self.errors[what] += 1
        return True

    async def _go_on(self, session: Session) -> None:
        foreign = session["ballbar_in_question"]
        if foreign is not None and self._rng.random() < 0.5:
            await self._accept(foreign["serial_number"])
            return
        name = {"planned": "start", "paused": "resume"}.get(session["state"], "confirm")
        answer = await self.act(name)
        if answer.is_error or foreign is not None or "robot answers" in session["reason"]:
            self._put_right()

    def _put_right(self) -> None:
        """Lay the bar down, plug it in, switch it on, bring back what belongs here."""
        for deed in ("plug_cable", "switch_on", "detach"):
            self.hands(deed)
        for given in self._cell.faults.given:
            if isinstance(given.fault, IdentityChanged):
                self._cell.faults.end(given.number)
        self.foreign_since_s = None

    async def _accept(self, serial_number: str) -> None:
        answer = await self.act("confirm", accept_serial_number=serial_number)
        if answer.is_success:
            self.foreign_since_s = None

    async def _do(self, session: Session) -> None:
        """Do by hand what a step asks for, or forget to, and confirm it."""
        step = session["step"]
        kind = step["kind"]
        if kind == "move" and self._errs("bar put back before a motion", 0.4):
            self._connect_any(session)
        if kind != "move" and not self._errs(f"early confirm of {kind}"):
            self._by_hand(step)
        elif kind == "detach" and self._rng.random() < 0.6:
            deed = self._rng.choice(("calibrator", "hold", "switch_off", "pull_cable"))
            self.errors[f"{deed} instead of laid down"] += 1
            self.hands(deed, **({"bars": "base"} if deed == "calibrator" else {}))
        answer = await self.act("confirm", step["id"])
        if answer.is_error:
            await asyncio.sleep(_LOOK_S)
            if self._rng.random() < 0.8:
                self._by_hand(step)
                self._put_right()
            elif self._rng.random() < 0.3:
                await self.act("skip", step["id"], reason="it cannot be done")

    def _by_hand(self, step: dict[str, Any]) -> None:
        match step["kind"]:
            case "place_base":
                self.hands("place_base", placement=step["placement"])
            case "clamp_cup":
                self.hands("clamp", base_point=step["base_point"])
            case "fit_ball" | "remove_ball" | "detach":
                self.hands(step["kind"])

    async def _read(self, session: Session) -> None:
        """Attach the ballbar, rightly or not, and have the length stored."""
        step = session["step"]
        self._attach(session)
        if self._errs("cable pulled", 0.05):
            self.hands("pull_cable")
        for _ in range(_TRIES):
            now = await self.see()
            other = now["step"] is None or now["step"]["id"] != step["id"]
            if other or now["suspicion"] or now["state"] != "running":
                return
            if self._rng.random() < 0.5 and (await self.act("store", step["id"])).is_success:
                return
            await asyncio.sleep(_LOOK_S)
        self.hands("plug_cable")
        self._put_as_asked(step)  # thinks again
        await asyncio.sleep(_LOOK_S)
        if (await self.act("store", step["id"])).is_error and self._rng.random() < 0.5:
            await self.act("skip", step["id"], reason="The length is out of range.")

    def _attach(self, session: Session) -> None:
        step = session["step"]
        if not self._errs("wrong connection"):
            self._put_as_asked(step)
            return
        match self._rng.choice(("pair", "pair", "pair", "left", "calibrator", "nothing")):
            case "pair":
                self._connect_any(session)
            case "calibrator":
                self.hands("calibrator", bars=step["artefact"] or "base")
            case "nothing":
                self.hands("detach")
            case _:
                pass

    def _put_as_asked(self, step: dict[str, Any]) -> None:
        if step["kind"] == "initialise":
            self.hands("calibrator", bars=step["artefact"])
            return
        first, second = (int(name[1:]) for name in step["points"])
        if step["kind"] == "connect_leg":
            self.hands("connect", base=first, tool=second)
        else:
            self.hands("side", artefact=step["artefact"], a=first, b=second)

    def _connect_any(self, session: Session) -> None:
        """Put the ballbar between two balls that it reaches, but not those that are asked for."""
        step = session["step"]
        asked = tuple(int(name[1:]) for name in step["points"]) if step["points"] else ()
        pairs = [pair for pair in itertools.product((1, 2, 3), (1, 2, 3)) if pair != asked]
        self._rng.shuffle(pairs)
        for first, second in pairs:
            if step["kind"] == "measure_side":
                if first < second and self.hands("side", artefact=step["artefact"], a=first, b=second):
                    return
            elif self.hands("connect", base=first, tool=second):
                return

    async def _answer(self, session: Session) -> None:
        """Look where the ballbar is and say so; now and then without looking."""
        step = session["step"]
        right = self._is_as_asked(step)
        if self._errs("wrong answer", 0.3):
            right = not right
        await self.act("answer", step["id"], answer="right_pair" if right else "reconnected")
        if not right:
            self.hands("detach")

    def _is_as_asked(self, step: dict[str, Any]) -> bool:
        asked = "calibrator" if step["kind"] == "initialise" else "-".join(step["points"] or ())
        return self._cell.seat in {asked, "-".join(reversed(asked.split("-")))}

    async def _meddle(self, session: Session) -> None:
        """Do what nobody asked for."""
        step_id = session["step"]["id"] if session["step"] else None
        match self._rng.choice(_MEDDLING):
            case "second tablet":
                self._tablet = "tablet-2" if self._tablet == "tablet-1" else "tablet-1"
                await self.act(self._rng.choice(("hand_over", "confirm", "store")), step_id)
                await self.act("hand_over")
            case "reload" if self._sent:
                key, body = self._rng.choice(self._sent[-4:])
                await self._post_act(key, body)
            case "cable":
                self.hands(self._rng.choice(("pull_cable", "plug_cable")))
            case "bar":
                self.hands("detach")
            case "skip":
                await self.act("skip", step_id, reason="no time")
            case "another ballbar":
                self.errors["another ballbar"] += 1
                self._cell.faults.add(IdentityChanged("ballbar", "777777"))
                self.foreign_since_s = self._cell.clock.now_s
            case "another robot":
                self.errors["another robot"] += 1
                self._cell.faults.add(IdentityChanged("robot", "777777"))
            case name if name in {"back", "pause", "stop", "retry"}:
                await self.act(name, step_id)
            case _:
                pass
