"""A session as the public API shows it, told by a test what to be: for states that are hard to reach.

It follows the routes and documents of the real service; whatever it is not told stays dull.
"""

import asyncio
import copy
import json
import math
import time
from types import SimpleNamespace

from fastapi import FastAPI, Header, Request
from fastapi.responses import JSONResponse, Response, StreamingResponse

from truepose.messages.catalogue import english
from truepose.sessions.engine.interlocks import motion_notice
from truepose.web.pages.reference import colours, static_file
from truepose.web.tablet import routes
from truepose_drivers.api import MotionGuard

_SAMPLED_S = 0.15  # from one sample to the next where nothing new is seen: each is painted
ALL_ACTS = ["store", "retry", "skip", "back", "pause", "stop", "abort", "confirm", "answer", "resume"]
CUPS = {"B1": (380.0, -150.0, 60.0), "B2": (640.0, 0.0, 60.0), "B3": (380.0, 150.0, 60.0)}
NESTS = {"T1": (470.0, 5.0, 305.0), "T2": (545.0, 95.0, 372.0), "T3": (590.0, -55.0, 330.0)}
ARM = [(0, 0, 0), (0, 0, 330), (75, 0, 330), (190, 0, 607), (420, 0, 640), (500, 0, 560), (520, 5, 430)]
ARM_BEFORE = [
    (0, 0, 0),
    (0, 0, 330),
    (70, 28, 330),
    (110, 45, 628),
    (330, 130, 760),
    (405, 160, 700),
    (430, 165, 640),
]


def scene(leg=None, *, before=None):
    points = [{"name": name, "position_mm": at, "kind": "cup"} for name, at in CUPS.items()]
    points += [{"name": name, "position_mm": at, "kind": "nest"} for name, at in NESTS.items()]
    return {
        "points": points,
        "arm_mm": ARM,
        "leg": leg,
        "stand_mm": (1500.0, -900.0, 1000.0),
        "look_at_mm": (470.0, 0.0, 200.0),
        "before_move_arm_mm": before,
    }


def step(kind="connect_leg", **said):
    dull = {
        "id": f"placement-1/{kind}",
        "kind": kind,
        "placement": 1,
        "config": None,
        "artefact": None,
        "points": None,
        "base_point": None,
        "expected_mm": None,
        "attempt": 1,
        "bars_mm": [150, 50],
        "nominal_mm": 300.0,
        "target_deg": None,
        "index": 57,
        "count": 431,
        "confirmed": False,
        "leg_number": None,
        "leg_count": None,
    }
    return {**dull, **said}


def leg(base=2, tool=3, *, pose=12, number=4, **said):
    """Return the step that connects cup `base` with nest `tool`."""
    id = f"placement-1/pose-{pose}/leg-{base}-{tool}"
    told = {"points": [f"B{base}", f"T{tool}"], "expected_mm": 300.42, "config": pose}
    return step(id=id, leg_number=number, leg_count=6, **{**told, **said})


def move(pose=12, **said):
    id = f"placement-1/pose-{pose}/move"
    return step("move", id=id, config=pose, target_deg=[0, 45, -30, 0, 30, 0], nominal_mm=None, **said)


def sample(state="in_range", length_mm=300.4213, *, stable=0.6, still=True):
    return {
        "time_s": 512.5,
        "length_mm": length_mm,
        "deviation_mm": None if length_mm is None else round(length_mm - 300.0, 4),
        "state": state,
        "stable_share": stable,
        "spread_mm": 0.0008,
        "robot_still": still,
        "can_store": state == "in_range",
        "why_not": None if state == "in_range" else state,
    }


class FakeDesk:
    """One session, number 3; acts are kept in the order in which they arrived, each key once."""

    def __init__(self):
        self.arrived = []  # every request of an act, repeated keys too
        self.acts = []  # what was carried out
        self.hands = []
        self.hands_refuse = None
        self.name_refused = None  # the sentence about each act's name
        self.simulated = True
        self.planning = None  # an event for which planning waits
        self.plan_keys = []
        self.sample = sample()
        self.scene = scene(["B2", "T3"])
        self.steps = [leg(1, 1), leg(2, 3), leg(3, 1)]
        self.sessions = []
        self.planned = []
        self.lost_answers = 0  # so many acts are carried out, and their answers lost
        self.session = {
            "id": 3,
            "name": "LR Mate, bay 2",
            "state": "running",
            "simulated": True,
            "robot": "FANUC LR Mate 200iC",
            "prompt": None,
            "motion_notice": english(motion_notice(MotionGuard(longest_piece_s=1.0))),
            "people": [],
            "reason": "",
            "reason_key": "",
            "ledger_number": 1,
            "step": leg(),
            "suspicion": None,
            "main_answer": None,
            "ballbar_in_question": None,
            "swaps_can_be_seen": True,
            "ballbar_attached": True,
            "robot_moving": False,
            "commands": ALL_ACTS,
            "progress": {
                "readings": 57,
                "planned": 431,
                "skipped_poses": 1,
                "elapsed_s": 600.0,
                "remaining_s": 5400.0,
                "pace_s_per_reading": 9.8,
            },
            "acting": None,
            "watching": 1,
            "last_outcome": None,
        }

    def show(self, **changed):
        """Change the session; every tablet hears of it."""
        number = self.session["ledger_number"] + 1
        self.session = {**copy.deepcopy(self.session), "ledger_number": number, **changed}

    def carried_out(self, *kinds):
        return [act for act in self.acts if act["act"] in kinds]

    def application(self):
        app = FastAPI()
        app.state.context = SimpleNamespace(sessions=SimpleNamespace(get=self._kept))
        app.include_router(routes.router)
        app.add_api_route("/static/tokens.css", colours)
        app.add_api_route("/static/{name}", static_file)
        api = "/api/v1/sessions"
        app.add_api_route(api, self._plan, methods=["POST"])
        app.add_api_route(f"{api}/3/situation", lambda: self.session)
        app.add_api_route(f"{api}/3/plan", lambda: {"steps": [{**_OPEN, **s} for s in self.steps]})
        app.add_api_route(f"{api}/3/scene", lambda: self.scene)
        app.add_api_route(f"{api}/3/live", self._live)
        app.add_api_route(f"{api}/3/commands", self._act, methods=["POST"])
        app.add_api_route(api, self._listed)
        app.add_api_route("/api/v1/simulated-hands", self._has_hands)
        app.add_api_route("/api/v1/simulated-hands", self._do, methods=["POST"])
        return app

    async def _kept(self, id):
        return SimpleNamespace(role="ballbar")

    async def _plan(self, request: Request):
        self.planned.append(await request.json())
        self.plan_keys.append(request.headers["idempotency-key"])
        while self.planning is not None and not self.planning.is_set():
            await asyncio.sleep(0.02)
        return JSONResponse(self.session, 201)

    async def _listed(self, after: int = 0):
        return [session for session in self.sessions if session["id"] > after]

    async def _has_hands(self):
        return {"simulated": self.simulated, "actions": [], "holding": "connect base 1 tool 1"}

    async def _do(self, request: Request):
        self.hands.append(await request.json())
        if self.hands_refuse:
            return _problem(409, self.hands_refuse)
        return Response(status_code=204)

    async def _act(self, request: Request, idempotency_key: str = Header()):
        sent = await request.json()
        act = {"act": sent.pop("command"), **sent, "key": idempotency_key}
        self.arrived.append(act)
        refusal = self._carry_out(act)
        if self.lost_answers:
            self.lost_answers -= 1
            await asyncio.sleep(0.05)
            return _problem(504, "The answer was lost on its way.")
        return refusal or {"sentence": "Done.", "entry": len(self.acts), "session": self.session}

    def _carry_out(self, act):
        if any(act["key"] == known["key"] for known in self.acts):
            return None
        if act.get("step_id") not in {None, self.session["step"]["id"]}:
            return _problem(409, "That step is no longer the present one.")
        if self.name_refused and act["act"] != "stop":
            return _problem(409, self.name_refused, "urn:truepose:problem:name")
        # Whoever waits for the act finds the session as it left it, and changes that one.
        self.show(acting={"tablet": act["tablet"], "person": act["person"]})
        self.acts.append(act)
        return None

    async def _live(self):
        return StreamingResponse(self._told(), media_type="text/event-stream")

    async def _told(self):
        said, sampled, sampled_s, heard_s = None, None, -math.inf, -math.inf
        while True:
            if said != self.session["ledger_number"]:
                said = self.session["ledger_number"]
                yield _event("situation", self.session)
            due = self.sample is not sampled or time.monotonic() - sampled_s > _SAMPLED_S
            if self.sample is not None and due:
                sampled, sampled_s = self.sample, time.monotonic()
                yield _event("sample", {**sampled, "sampled_at_ms": time.time() * 1000})
            if time.monotonic() - heard_s > 1:
                heard_s = time.monotonic()
                yield ": still here\n\n"
            await asyncio.sleep(0.05)


_OPEN = {"outcome": "open", "length_mm": None, "text": ""}


def _event(name, document):
    return f"event: {name}\ndata: {json.dumps(document)}\n\n"


def _problem(status, detail, type="urn:truepose:problem:conflict"):
    body = {"type": type, "status": status, "detail": detail}
    return JSONResponse(body, status, media_type="application/problem+json")
