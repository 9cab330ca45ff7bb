"""Records as pages name them: title, address and state, what each came of, what came of it, the next step."""

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import Final, TypeVar

from truepose.domain.session import SessionState
from truepose.messages.catalogue import Catalogue
from truepose.storage.errors import NotFoundError
from truepose.storage.records import JobKind, JobState
from truepose.storage.results.items import FAILED, NO_LIMIT, PASSED, UNDECIDED, WORSE, WorkItem, WorkKind
from truepose.storage.results.lineage import Lineage
from truepose.web.pages.next_action import NextAction, action_after
from truepose.web.pages.rendering import MissingPageError, Visit, moment
from truepose.web.resources import number_of

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
    WorkKind.VALIDATION: {
        PASSED: ("good", "work.passed"),
        FAILED: ("bad", "work.failed"),
        UNDECIDED: ("warn", "work.undecided"),
        NO_LIMIT: ("idle", "work.no_limit"),
        WORSE: ("bad", "work.worse"),
    },
    WorkKind.JOB: {
        JobState.QUEUED: ("busy", "job.queued"),
        JobState.RUNNING: ("busy", "job.running"),
        JobState.SUCCEEDED: ("good", "job.succeeded"),
        JobState.FAILED: ("bad", "job.failed"),
        JobState.CANCELLED: ("idle", "job.cancelled"),
        JobState.INTERRUPTED: ("warn", "job.interrupted"),
    },
}
MAKES: Final = {  # what a job makes, and the key of its own title
    JobKind.IDENTIFICATION: (WorkKind.IDENTIFICATION, "job.identification"),
    JobKind.VALIDATION: (WorkKind.VALIDATION, "job.validation"),
    JobKind.DIAGNOSIS: (WorkKind.DIAGNOSIS, "job.diagnosis"),
    JobKind.PLAN: (WorkKind.SESSION, "job.plan"),
    JobKind.BALLBAR_PLAN: (WorkKind.SESSION, "job.plan"),
    JobKind.CONTACT_PLAN: (WorkKind.SESSION, "job.plan"),
    JobKind.CORRECTION: (WorkKind.CORRECTION, "job.correction"),
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
    look, state = state_look(item.kind, item.state)
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


def state_look(kind: WorkKind, state: str) -> tuple[str, str]:
    """Return the look of a state and the key of its word."""
    other = _REFUSED if kind is WorkKind.IDENTIFICATION else ("", "")
    return _STATES.get(kind, {}).get(state, other)


def session_states(words: Catalogue) -> dict[str, str]:
    """Return each state of a session, as documents name it, with what people read."""
    return {str(state): words.say(key) for state, (_, key) in _STATES[WorkKind.SESSION].items()}


Record = TypeVar("Record")
_REPORTED: Final = (WorkKind.IDENTIFICATION, WorkKind.DIAGNOSIS, WorkKind.VALIDATION)


@dataclass(frozen=True, slots=True)
class Trail:
    """A record among its own."""

    here: str  # address of the record itself
    report: str  # its address; empty where a record of this kind has none
    lineage: Lineage
    links: tuple[Link, ...]
    step: NextAction | None


async def trail_of(visit: Visit, kind: WorkKind, number: int) -> Trail:
    """Return a record's trail; the record must exist."""
    lineage = await visit.here.lineages.of(kind, number)
    links = tuple(link_to(item, visit.words) for item in lineage.items)
    report = f"/reports/{kind.value}/{number}" if kind in _REPORTED else ""
    step = action_after(await _judged(visit, kind, lineage))
    return Trail(address_of(kind, number), report, lineage, links, step)


async def _judged(visit: Visit, kind: WorkKind, lineage: Lineage) -> Lineage:
    """Return what the next step follows from: of a model also what was made of its identification since."""
    made_by = lineage.newest(WorkKind.IDENTIFICATION)
    if kind not in {WorkKind.MODEL, WorkKind.VALIDATION} or made_by is None:
        return lineage
    return await visit.here.lineages.of(made_by.kind, made_by.id)


async def record_at(id: str, get: Callable[[int], Awaitable[Record]]) -> Record:
    """Return the record of a number in an address; raises MissingPageError where it names none."""
    number = number_of(id)
    if number is None:
        raise MissingPageError
    try:
        return await get(number)
    except NotFoundError as error:
        raise MissingPageError from error
