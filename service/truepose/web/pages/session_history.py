"""Who did what in a session: what people had it do, left out, took back, decided and confirmed.

Confirmations are counted: a session with the ballbar has hundreds. Each stands in the ledger by itself.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final, TypeAlias

from truepose.domain.ballbar import StepKind
from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.session import SessionState, config_of
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, Text, message, together
from truepose.sessions.ballbar import step_ids
from truepose.storage.people import ActRecord
from truepose.storage.records import AdditionRecord, LedgerRecord, StateChange
from truepose.web.api.authority import TAKEN_FROM
from truepose.web.context import Context
from truepose.web.pages.rendering import moment

if TYPE_CHECKING:
    from truepose.reports.traceability import Event

Told: TypeAlias = tuple[str, str, Text]  # recorded at, person, what
_AWAITS, _RUNS = SessionState.AWAITING_CONFIRMATION, SessionState.RUNNING
# What `_what` and `_counted` tell of. A session of a thousand configurations has thousands of other entries.
_ANSWERED_FOR: Final = (
    EntryKind.CONFIRMED,
    EntryKind.MEASURED,
    EntryKind.SKIPPED,
    EntryKind.REOPENED,
    EntryKind.ANSWERED,
    EntryKind.CONTROL,
)
_DEVICES: Final = {"tracker": "laser tracker", "robot": "robot controller", "ballbar": "ballbar"}


@dataclass(frozen=True, slots=True)
class OnRecord:
    """All that is on record of what people did in a session."""

    number: int
    states: Sequence[StateChange]
    lines: Sequence[LedgerRecord]
    additions: Sequence[AdditionRecord] = ()
    authority: Sequence[ActRecord] = ()  # taken from somebody


async def acts_of_session(here: Context, number: int, words: Catalogue) -> "list[Event]":
    """Return what was done in a session, by whom and when, oldest first."""
    return events_of(
        OnRecord(
            number,
            await here.sessions.states(number),
            await here.session_desk.ledger.of_kinds(number, _ANSWERED_FOR),
            await here.sessions.additions(number),
            await _authority(here, number),
        ),
        words,
    )


def events_of(record: OnRecord, words: Catalogue) -> "list[Event]":
    """Return what somebody answers for, oldest first; what is counted comes at the end."""
    from truepose.reports.traceability import Event

    told = [
        *_states(record),
        *_added(record.additions),
        *_taken_over(record.authority),
        *(one for line in record.lines for one in _of_line(line)),
    ]
    return [
        *(Event(moment(at), person, what) for at, person, what in sorted(told, key=lambda one: one[0])),
        *(Event(when, person, what) for when, person, what in _counted(record, words)),
    ]


async def _authority(here: Context, number: int) -> list[ActRecord]:
    await here.people.log.written()
    return await here.people.acts.with_reason("claim_authority", f"/api/v1/sessions/{number}/authority")


def _states(record: OnRecord) -> Iterator[Told]:
    """Yield each state; the same question again, and the word that the cell is clear, are counted."""
    asked: set[Text] = set()
    for before, one in zip((None, *record.states), record.states, strict=False):
        answered = before is not None and before.state is _AWAITS and one.state is _RUNS
        if answered or (one.state is _AWAITS and one.reason in asked):
            continue
        if one.state is _AWAITS:
            asked.add(one.reason)
        yield one.recorded_at, one.person or "", _entered(record.number, one)


def _entered(number: int, one: StateChange) -> Message:
    state = message(f"session.{one.state.value}")
    return message("event.session", number=number, state=state, reason=one.reason)


def _added(additions: Iterable[AdditionRecord]) -> Iterator[Told]:
    for one in additions:
        yield one.recorded_at, one.added.person, message("event.added", number=len(one.added.stops))


def _taken_over(acts: Iterable[ActRecord]) -> Iterator[Told]:
    for one in acts:
        held = (one.act.reason or "").removeprefix(TAKEN_FROM)
        yield one.act.happened_at, one.act.person or "", message("event.taken_over", held=held)


def _of_line(line: LedgerRecord) -> Iterator[Told]:
    entry = line.entry
    what = _what(entry)
    if what is not None:
        yield line.recorded_at, _person(entry), what


def _person(entry: LedgerEntry) -> str:
    """Return who did what a line says; "" where the service did it while somebody acted."""
    if entry.identity is not None:
        return entry.identity.person or ""
    return "" if entry.kind is EntryKind.SKIPPED and entry.key is None else entry.person or ""


def _what(entry: LedgerEntry) -> Message | None:
    """Return what a line says that somebody answers for; None of readings and of what is counted."""
    match entry.kind:
        case EntryKind.SKIPPED:
            key = "event.not_measured" if entry.key is None else "event.left_out"
            return message(key, what=step_text(entry.step_id), reason=entry.text)
        case EntryKind.REOPENED if entry.key is not None:
            return message("event.again", what=step_text(entry.step_id), reason=entry.text)
        case EntryKind.ANSWERED:
            return message("event.doubt.again", what=step_text(entry.step_id))
        case EntryKind.MEASURED if entry.suspicion is not None:
            return message("event.doubt.kept", what=step_text(entry.step_id))
        case EntryKind.CONFIRMED if entry.text:
            return message("event.word", what=step_text(entry.step_id), reason=entry.text)
        case EntryKind.CONTROL:
            return _control(entry)
    return None


def _control(entry: LedgerEntry) -> Message | None:
    if entry.identity is not None and entry.identity.finding == "accepted":
        taken = entry.identity
        return message("event.accepted", device=_DEVICES[taken.device], serial=taken.serial or "?")
    if entry.control is Control.HAND_OVER:
        return message("event.hand_over", tablet=entry.tablet or "?")
    return message("event.zero_lost") if entry.control is Control.ZERO_LOST else None


def step_text(step_id: str) -> Text:
    """Return what a step is of: a configuration, a pair of cups, or the step by its own name."""
    config = config_of(step_id)
    if config is not None:
        return message("event.step.stop", config=config)
    if step_ids.kind_of(step_id) is StepKind.CONNECT_LEG:
        base, tool = step_ids.points_of(step_id)
        return together(_pose(step_id), message("event.step.leg", base=base, tool=tool))
    return _pose(step_id) if step_ids.is_of_a_pose(step_id) else step_id


def _pose(step_id: str) -> Message:
    named = next(part for part in step_id.split("/") if part.startswith("pose-"))
    return message("event.step.stop", config=int(named.removeprefix("pose-")))


def _counted(record: OnRecord, words: Catalogue) -> Iterator[Told]:
    """Yield how often each person confirmed something, and stored a length by hand; from when to when."""
    confirmed: defaultdict[str, list[str]] = defaultdict(list)
    moved: Counter[str] = Counter()
    for person, at, moves in _confirmations(record):
        confirmed[person].append(at)
        moved[person] += moves
    for person, times in confirmed.items():
        yield (
            _span(times, words),
            person,
            message("event.confirmed", number=len(times), motions=moved[person]),
        )
    for person, times in _stored_by_hand(record.lines).items():
        yield _span(times, words), person, message("event.by_hand", number=len(times))


def _stored_by_hand(lines: Sequence[LedgerRecord]) -> dict[str, list[str]]:
    stored: defaultdict[str, list[str]] = defaultdict(list)
    for line in lines:
        if line.entry.length is not None and line.entry.length.by_hand:
            stored[line.entry.person or ""].append(line.recorded_at)
    return stored


def _confirmations(record: OnRecord) -> Iterator[tuple[str, str, bool]]:
    """Yield who confirmed, when, and whether the arm moved upon it."""
    for before, one in pairwise(record.states):
        if before.state is _AWAITS and one.state is _RUNS and one.person:
            yield one.person, one.recorded_at, True
    for line in record.lines:
        entry = line.entry
        if entry.kind is EntryKind.CONFIRMED and entry.person:
            yield entry.person, line.recorded_at, step_ids.kind_of(entry.step_id) is StepKind.MOVE


def _span(at: Sequence[str], words: Catalogue) -> str:
    first, last = moment(min(at)), moment(max(at))
    return first if first == last else words.say("range", low=first, high=last)
