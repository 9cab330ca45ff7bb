"""Health checks: what is looked at, and what it means for whoever runs the service; functions of a state."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from truepose.health import Clock, Copies, DeviceLink, Records, State
from truepose.messages.message import Message, message

Verdict: TypeAlias = Literal["ok", "warn", "bad"]
_ORDER: Final[tuple[Verdict, ...]] = ("ok", "warn", "bad")
_SLOW_COMMIT_S: Final = 0.05  # a disk takes 5 ms; a network file system 170 ms in the median
_UNBEARABLE_COMMIT_S: Final = 0.5
_SCARCE_BYTES: Final = 2 * 2**30
_HARDLY_ANY_BYTES: Final = 128 * 2**20
_MOVED_S: Final = 5.0  # what a time server corrects at once
_LATER_S: Final = 60.0
_SOON_DAYS: Final = 30
_OVERDUE: Final = 2.0  # of the time between two copies
_MANY_JOBS: Final = 20
_GB: Final = 1e9
_HOUR_S: Final = 3600.0


@dataclass(frozen=True, slots=True)
class Check:
    """One thing that was looked at."""

    name: str
    verdict: Verdict
    sentence: Message

    @property
    def weight(self) -> int:
        """How much it matters: what is wrong comes first on a page."""
        return _ORDER.index(self.verdict)


def checks(state: State) -> list[Check]:
    """Return everything that is looked at, in the order of its weight."""
    return [
        _database(state.records),
        *_server(state.records),
        _disk(state.records),
        _chain(state.records),
        _backup(state),
        _devices(state.devices),
        _workers(state),
        _clock(state.clock),
        _certificates(state),
        _log(state.lines_lost),
    ]


def worst(found: list[Check]) -> Verdict:
    """Return the verdict of them all."""
    return max((check.verdict for check in found), key=_ORDER.index, default="ok")


def _database(records: Records) -> Check:
    if not records.readable:
        return Check("database", "bad", message("health.database.unreadable"))
    if records.refused:
        return Check("database", "bad", message("health.database.refused", why=records.refused))
    if records.server_doubts is not None and (records.late or records.commit_s is None):
        return Check("database", "warn", message("health.server.silent"))
    if records.late:
        return Check("database", "warn", message("health.database.late"))
    if records.commit_s is None:
        return Check("database", "warn", message("health.database.silent"))
    ms = {"ms": 1000 * records.commit_s}
    if records.commit_s > _UNBEARABLE_COMMIT_S:
        return Check("database", "bad", message("health.database.bad", **ms))
    if records.commit_s > _SLOW_COMMIT_S:
        return Check("database", "warn", message("health.database.warn", **ms))
    return Check("database", "ok", message("health.database.ok", **ms))


def _server(records: Records) -> Iterator[Check]:
    """Yield what is to be known of a server that keeps the records; nothing of a file."""
    off = records.server_doubts
    if off is None:
        return
    if "fsync" in off:
        yield Check("server", "bad", message("health.server.fsync"))
    elif "full_page_writes" in off:
        yield Check("server", "warn", message("health.server.pages"))
    else:
        yield Check("server", "ok", message("health.server.ok"))


def _disk(records: Records) -> Check:
    free = {"gb": records.free_bytes / _GB}
    if records.reserve_used:
        return Check("disk", "bad", message("health.disk.reserve", **free))
    if records.free_bytes < _HARDLY_ANY_BYTES:
        return Check("disk", "bad", message("health.disk.bad", **free))
    if records.free_bytes < _SCARCE_BYTES:
        return Check("disk", "warn", message("health.disk.warn", **free))
    if records.server_doubts is not None:
        return Check("disk", "ok", message("health.disk.here", **free))
    return Check("disk", "ok", message("health.disk.ok", **free))


def _chain(records: Records) -> Check:
    if records.damage:
        return Check("chain", "bad", message("health.chain.bad", what=records.damage))
    if records.unchecked:
        return Check("chain", "warn", message("health.chain.unchecked", why=records.unchecked))
    if records.integrity == "whole":
        return Check("chain", "ok", message("health.chain.ok", links=records.links))
    return Check("chain", "ok", message("health.chain.checking", percent=100 * records.checked_share))


def _backup(state: State) -> Check:
    copies = state.copies
    if copies is None and state.simulated:
        return Check("backup", "ok", message("health.backup.simulated"))
    if copies is None:
        return Check("backup", "warn", message("health.backup.none"))
    if copies.fault:
        return Check("backup", "bad", message("health.backup.failed", why=copies.fault))
    if copies.age_s is None:
        return Check("backup", "warn", message("health.backup.first"))
    return _by_age(copies, copies.age_s)


def _by_age(copies: Copies, age_s: float) -> Check:
    hours = {"hours": age_s / _HOUR_S, "every": copies.every_s / _HOUR_S}
    if age_s > _OVERDUE * copies.every_s:
        return Check("backup", "bad", message("health.backup.late", **hours))
    return Check("backup", "ok", message("health.backup.ok", **hours))


def _devices(devices: Mapping[str, DeviceLink]) -> Check:
    amiss = [*_amiss(devices)]
    if amiss:
        return Check("devices", "warn", message("health.devices.amiss", which=tuple(amiss)))
    linked = sum(link.connected for link in devices.values())
    return Check("devices", "ok", message("health.devices.ok", linked=linked, of=len(devices)))


def _amiss(devices: Mapping[str, DeviceLink]) -> Iterator[Message]:
    for name, link in devices.items():
        if link.foreign:
            yield message("health.devices.foreign", name=name)
        elif link.fault:
            yield message("health.devices.fault", name=name, why=link.fault)


def _workers(state: State) -> Check:
    running, waiting = state.jobs.get("running", 0), state.jobs.get("queued", 0)
    verdict: Verdict = "warn" if waiting > _MANY_JOBS else "ok"
    return Check("workers", verdict, message("health.workers", running=running, waiting=waiting))


def _clock(clock: Clock) -> Check:
    if clock.ahead_s is not None and clock.ahead_s < -_LATER_S:
        return Check("clock", "bad", message("health.clock.behind", seconds=-clock.ahead_s))
    if abs(clock.moved_s) > _MOVED_S:
        return Check("clock", "warn", message("health.clock.moved", seconds=clock.moved_s))
    return Check("clock", "ok", message("health.clock.ok"))


def _certificates(state: State) -> Check:
    days = state.certificates
    expired = tuple(name for name, left in days.items() if left < 0)
    soon = tuple(name for name, left in days.items() if 0 <= left <= _SOON_DAYS)
    if expired:
        return Check("certificates", "bad", message("health.certificates.expired", which=expired))
    if soon:
        nearest = min(left for left in days.values() if left >= 0)
        return Check("certificates", "warn", message("health.certificates.soon", which=soon, days=nearest))
    if state.uncertified and not state.simulated:
        return Check("certificates", "warn", message("health.certificates.unsaid", which=state.uncertified))
    if not days:
        return Check("certificates", "ok", message("health.certificates.none"))
    return Check("certificates", "ok", message("health.certificates.ok", number=len(days)))


def _log(lost: int) -> Check:
    if lost:
        return Check("log", "warn", message("health.log.lost", lines=lost))
    return Check("log", "ok", message("health.log.ok"))
