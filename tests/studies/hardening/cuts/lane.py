"""One tablet in a shop: cut, tapped, healed, and then asked what became of every tap."""

import asyncio
import json
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from tests.studies.hardening.cuts.onlooker import DONE, Onlooker, answered_in, entries_of
from tests.studies.hardening.cuts.person import Person, Sent, Tap

_WAYS: Final = ("cut", "lose_answers", "delay", "roam")
_DOCK: Final = ("pause", "stop", "retry", "back", "skip")
_DOCK_SHARE: Final = (0.35, 0.15, 0.2, 0.1, 0.2)
_GOES_ON: Final = 0.7
_SETTLED_S: Final = 60.0
_SAID_S: Final = 15.0  # a page asks first what stands now, over a connection that may be dead
# What was pressed before that lets nothing move; the clock of the page runs up to so much behind.
_LATE_S: Final = 3.3
_REST: Final = """() => document.querySelector("#link").dataset.state === "up" && Object.entries(localStorage)
  .filter(([name]) => name.startsWith("truepose.taps.")).every(([, taps]) => taps === "[]")"""


@dataclass(slots=True)
class Tally:
    """What was seen."""

    cuts: dict[str, int] = field(default_factory=dict)
    sessions: int = 0
    taps: int = 0
    tapped_without_a_link: int = 0
    holds: int = 0
    repeated: int = 0  # taps that were sent more than once
    kept_unanswered: int = 0  # carried out, their first answer lost
    dropped: int = 0  # refused with a sentence
    unheard: int = 0  # the page said that nobody had heard
    unheard_but_done: int = 0
    late_refused: int = 0
    motions: int = 0
    lost: list[str] = field(default_factory=list)
    doubled: list[str] = field(default_factory=list)
    disordered: list[str] = field(default_factory=list)
    silent: list[str] = field(default_factory=list)
    stale: list[str] = field(default_factory=list)
    stuck: list[str] = field(default_factory=list)

    @property
    def faults(self) -> list[str]:
        """Return everything that was wrong."""
        return self.lost + self.doubled + self.disordered + self.silent + self.stale + self.stuck

    def written(self) -> str:
        """Return it as JSON."""
        return json.dumps(asdict(self), indent=1)


@dataclass(slots=True)
class Lane:
    """A page, its wire, its service; `path` is where the session is asked for."""

    person: Person
    wire: Any
    onlooker: Onlooker
    database: Path
    rng: np.random.Generator
    tally: Tally
    path: str = ""

    async def cut_once(self) -> None:
        """Cut the network at a random moment of some taps, heal it, and judge."""
        person, rng = self.person, self.rng
        known, tapped, arrived = set(person.sent), len(person.taps), len(self.onlooker.arrivals)
        await person.page.evaluate("document.querySelector('#said').hidden = true, window.said = []")
        way = str(rng.choice(_WAYS))
        tapping = asyncio.create_task(self._tap())
        await asyncio.sleep(float(rng.uniform(0.0, 2.0 if rng.random() < 0.4 else 0.3)))
        getattr(self.wire, way)()
        await asyncio.sleep(float(rng.choice([rng.uniform(0.02, 0.6), rng.uniform(0.6, 4.5)])))
        if way != "roam":
            self.wire.heal()
        await tapping
        if not await self._at_rest():
            self.tally.stuck.append(f"{self.path}: {way}: {await self._standing()}")
            return
        self.tally.cuts[way] = self.tally.cuts.get(way, 0) + 1
        new = [sent for key, sent in person.sent.items() if key not in known]
        said = await self._said(any(DONE not in sent.statuses for sent in new))
        self._judge(way, person.taps[tapped:], new, arrived, said)

    async def _tap(self) -> None:
        person, rng = self.person, self.rng
        for _ in range(int(rng.integers(1, 4))):
            screen = await person.screen()
            if rng.random() < _GOES_ON:
                await person.go_on(screen, self.path)
            else:
                await person.tap(str(rng.choice(_DOCK, p=_DOCK_SHARE)))
            self.tally.tapped_without_a_link += await person.page.evaluate(
                "document.querySelector('#link').dataset.state !== 'up'"
            )
            await asyncio.sleep(float(rng.uniform(0.0, 0.7)))

    async def _at_rest(self) -> bool:
        async def rest() -> None:
            while any(s.under_way for s in self.person.sent.values()) or not await self.person.page.evaluate(
                _REST
            ):
                await asyncio.sleep(0.05)
            await asyncio.sleep(0.1)  # a sentence that comes with the last answer is drawn

        try:
            await asyncio.wait_for(rest(), _SETTLED_S)
        except TimeoutError:
            return False
        return True

    async def _said(self, something: bool) -> list[str]:
        """Return what the page has said, once it has where there is something to say."""
        end_s = time.monotonic() + (_SAID_S if something else 0.0)
        while not (said := await self.person.page.evaluate("window.said")) and time.monotonic() < end_s:
            await asyncio.sleep(0.1)
        return list(said)

    async def _standing(self) -> str:
        return str(
            await self.person.page.evaluate(
                "JSON.stringify([document.body.dataset.screen, {...localStorage}])"
            )
        )

    def _judge(self, way: str, taps: list[Tap], new: list[Sent], arrived: int, said: list[str]) -> None:
        tally, here = (
            self.tally,
            f"{self.path}: {way}: {[t.act for t in taps]}: {[(s.act, s.statuses) for s in new]}",
        )
        tally.taps += len(taps)
        kept = entries_of(self.database, [sent.key for sent in new])
        held = [sent for sent in new if sent.held]
        tally.holds += len(held)
        free = [sent for sent in new if not sent.held]
        queued = [tap for tap in taps if tap.is_queued]
        only_now = [tap for tap in taps if not tap.is_queued]
        wanted = sorted(tap.act for tap in queued)
        came = sorted(sent.act for sent in free)
        # What goes now or never has no queue to be lost from: it is held, or free without a question.
        surplus = list(came)
        for act in wanted:
            if act in surplus:
                surplus.remove(act)
            else:
                tally.lost.append(f"{here}: {act} was tapped and never sent")
        for tap in only_now:
            if tap.act in surplus:
                surplus.remove(tap.act)
        tally.doubled.extend(f"{here}: {act} was sent and never tapped" for act in surplus)
        for sent in new:
            self._judge_one(here, sent, kept[sent.key], said)
        numbers = [kept[sent.key][0] for sent in free if kept[sent.key]]
        if numbers != sorted(numbers):
            tally.disordered.append(f"{here}: lines {numbers}")
        self._judge_age(here, arrived)

    def _judge_one(self, here: str, sent: Sent, lines: list[int], said: list[str]) -> None:
        tally = self.tally
        times = [a for a in self.onlooker.arrivals if a.key == sent.key]
        tally.repeated += len(times) > 1
        done = [a for a in times if a.status == DONE]
        tally.kept_unanswered += len(done) > sent.statuses.count(DONE)
        if len(lines) > 1:
            tally.doubled.append(f"{here}: {sent.act} stands on the lines {lines}")
        if DONE in sent.statuses:
            if not done or sent.key not in answered_in(self.database):
                tally.lost.append(f"{here}: {sent.act} was answered and is not kept")
            return
        if sent.statuses:
            tally.dropped += 1
            if lines:
                tally.silent.append(f"{here}: {sent.act} was refused, and stands on line {lines}")
        else:
            tally.unheard += 1
            tally.unheard_but_done += bool(lines)
        if not said:
            tally.silent.append(f"{here}: nothing was said of {sent.act}")

    def _judge_age(self, here: str, arrived: int) -> None:
        for arrival in self.onlooker.arrivals[arrived:]:
            sent = self.person.sent.get(arrival.key)
            if sent is None or not sent.held:
                continue
            late = arrival.arrived_s - sent.begun_s > _LATE_S
            self.tally.late_refused += late and arrival.status != DONE
            if late and arrival.status == DONE:
                self.tally.stale.append(
                    f"{here}: {sent.act} was {arrival.arrived_s - sent.begun_s:.1f} s old"
                )
