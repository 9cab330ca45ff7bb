"""Records as pages name them: what each is called, where its page is, how its state looks."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from truepose.domain.measurement.session import SessionState
from truepose.storage.records import JobState
from truepose.storage.work.items import WorkItem, WorkKind
from truepose.web.visiting.moments import moment
from truepose.words.catalogue import Catalogue

_PLURALS: Final = {WorkKind.DIAGNOSIS: "diagnoses"}
_TITLES: Final = {
    WorkKind.SESSION: "work.session",
    WorkKind.CAMPAIGN: "work.campaign",
    WorkKind.IDENTIFICATION: "work.identification",
    WorkKind.DIAGNOSIS: "work.diagnosis",
    WorkKind.MODEL: "work.model",
    WorkKind.VALIDATION: "work.validation",
    WorkKind.CORRECTION: "work.correction",
    WorkKind.JOB: "work.job",
}
_STATES: Final[Mapping[WorkKind, Mapping[str, tuple[str, str]]]] = {
    WorkKind.SESSION: {
        SessionState.PLANNED: ("idle", "session.planned"),
        SessionState.RUNNING: ("busy", "session.running"),
        SessionState.PAUSING: ("busy", "session.pausing"),
        SessionState.PAUSED: ("warn", "session.paused"),
        SessionState.AWAITING_CONFIRMATION: ("warn", "session.awaiting_confirmation"),
        SessionState.ABORTING: ("busy", "session.aborting"),
        SessionState.ABORTED: ("warn", "session.aborted"),
        SessionState.FINISHED: ("good", "session.finished"),
        SessionState.FAILED: ("bad", "session.failed"),
    },
    WorkKind.IDENTIFICATION: {"converged": ("good", "work.converged")},
    WorkKind.DIAGNOSIS: {
        "consistent": ("good", "verdict.consistent"),
        "explained": ("good", "verdict.explained"),
        "partly_explained": ("warn", "verdict.partly_explained"),
        "unexplained": ("bad", "verdict.unexplained"),
        "not_answered": ("idle", "verdict.not_answered"),
    },
    WorkKind.VALIDATION: {"passed": ("good", "work.passed"), "failed": ("bad", "work.failed")},
    WorkKind.JOB: {
        JobState.QUEUED: ("busy", "job.queued"),
        JobState.RUNNING: ("busy", "job.running"),
        JobState.SUCCEEDED: ("good", "job.succeeded"),
        JobState.FAILED: ("bad", "job.failed"),
        JobState.CANCELLED: ("idle", "job.cancelled"),
        JobState.INTERRUPTED: ("warn", "job.interrupted"),
    },
}
_REFUSED: Final = ("bad", "work.refused")  # an identification that came to no model


@dataclass(frozen=True, slots=True)
class Link:
    """A record in a list."""

    kind: str
    href: str
    title: str
    name: str
    robot: str
    when: str
    simulated: bool
    look: str  # of its state; empty where it has none
    state: str


def address_of(kind: WorkKind, number: int) -> str:
    """Return where the page of a record is."""
    return f"/{_PLURALS.get(kind, f'{kind.value}s')}/{number}"


def title_of(kind: WorkKind, number: int, words: Catalogue) -> str:
    """Return what a record is called."""
    return words.say(_TITLES[kind], number=number)


def link_to(item: WorkItem, words: Catalogue) -> Link:
    """Return a record as lists show it."""
    look, state = _state_of(item)
    serial = words.say("page.serial_number", serial=item.serial_number) if item.serial_number else ""
    return Link(
        kind=item.kind.value,
        href=address_of(item.kind, item.id),
        title=title_of(item.kind, item.id, words),
        name=item.name,
        robot=", ".join(filter(None, (item.robot, serial))),
        when=moment(item.recorded_at),
        simulated=item.simulated,
        look=look,
        state=words.say(state) if state else "",
    )


def state_words(kind: WorkKind, state: str) -> tuple[str, str]:
    """Return the look of a state and the key of its word."""
    other = _REFUSED if kind is WorkKind.IDENTIFICATION else ("", "")
    return _STATES.get(kind, {}).get(state, other)


def _state_of(item: WorkItem) -> tuple[str, str]:
    return state_words(item.kind, item.state)
