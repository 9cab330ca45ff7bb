"""Sessions: their plan and set-up, every state they were in, what was skipped, registered and noted."""

import asyncio
import dataclasses
from functools import cache, partial
from typing import Any, TypeAlias

from sqlalchemy import ColumnElement, Connection, Select, case, exists, func, select

from truepose.domain.ballbar import BallbarPlan
from truepose.domain.contacts import ContactPlan
from truepose.domain.ledger import EntryKind
from truepose.domain.session import (
    IdentityTaken,
    Progress,
    Registration,
    SessionPlan,
    SessionRole,
    SessionState,
    StopSkipped,
    config_of,
)
from truepose.messages.message import Text, message
from truepose.storage.database import Database
from truepose.storage.documents import from_document, text_from, to_document
from truepose.storage.engine.dialects import entries_at, is_object_at, length_at, text_at
from truepose.storage.errors import ConflictError
from truepose.storage.ledger.added_stops import additions_to, stops_added_to
from truepose.storage.ledger.pose_counts import measured_poses, skipped_poses
from truepose.storage.queries import NumberedRecords
from truepose.storage.record_insertion import add_event, add_row, answered_number, once
from truepose.storage.records import AdditionRecord, RequestKey, SessionRecord, SessionSetup, StateChange
from truepose.storage.results.campaigns import in_cell, is_simulated, simulated_session
from truepose.storage.rows import from_row
from truepose.storage.tables import (
    added_stops,
    events,
    links,
    notes,
    readings,
    session_entries,
    session_states,
    sessions,
)

AnyPlan: TypeAlias = SessionPlan | BallbarPlan | ContactPlan
PROGRESS = "session.progress"
IDENTITY = "session.identity"


def add_session(connection: Connection, name: str, setup: SessionSetup, plan: AnyPlan) -> int:
    """Append a planned session inside the caller's transaction and return its number."""
    number = add_row(
        connection,
        sessions,
        name=name,
        role=_role_of(plan),
        setup=to_document(setup),
        plan=to_document(plan),
    )
    add_state(connection, number, SessionState.PLANNED, message("session.plan_stored"), None)
    return number


def _role_of(plan: AnyPlan) -> SessionRole:
    if isinstance(plan, SessionPlan):
        return plan.role
    return "ballbar" if isinstance(plan, BallbarPlan) else "contacts"


def add_state(
    connection: Connection, session_id: int, state: SessionState, reason: Text, person: str | None
) -> None:
    """Append a state, and its event, inside the caller's transaction."""
    values: dict[str, Any] = {"state": state.value, "reason": reason, "person": person}
    add_row(connection, session_states, session_id=session_id, **values)
    add_event(connection, "session.state", to_document(values), session_id=session_id)


def add_note(connection: Connection, session_id: int, text: Text) -> None:
    """Append a sentence."""
    add_row(connection, notes, session_id=session_id, text=text)
    add_event(connection, "session.note", {"text": to_document(text)}, session_id=session_id)


class SessionRepository(NumberedRecords[SessionRecord]):
    """All queries about sessions."""

    def __init__(self, database: Database) -> None:
        super().__init__(database, "session", sessions, _records, partial(from_row, SessionRecord))

    async def add(
        self, name: str, setup: SessionSetup, plan: AnyPlan, key: RequestKey | None = None, notice: Text = ""
    ) -> int:
        """Store a planned session, with what is to be watched of it as its first note; return its number."""

        def create(connection: Connection) -> int:
            number = add_session(connection, name, setup, plan)
            # Within the transaction: of a request that is sent twice at once, and of one that is cut off
            # here, the session has its note once.
            if notice:
                add_note(connection, number, notice)
            return number

        return await self._database.write_new(lambda c: once(c, key, "session", create))

    async def require_intact(self, session_id: int) -> None:
        """Raise DamagedDatabaseError where a record of a session is not as it was written."""
        await self._database.require_intact(session_id)

    async def chain_head(self, session_id: int) -> str:
        """Return the hash of the newest link of a session's records, in hexadecimal."""
        query = select(links.c.hash).where(links.c.stream == session_id).order_by(links.c.id.desc()).limit(1)
        newest = await self._value(query)
        return "" if newest is None else bytes(newest).hex()

    async def answered(self, key: RequestKey) -> int | None:
        """Return the session that a request with this key made before; raises KeyReusedError."""
        return await self._database.read(lambda c: answered_number(c, key, "session"))

    async def in_state(self, *states: SessionState) -> list[SessionRecord]:
        """Return the sessions that stand in one of `states`, oldest first."""
        query = _records().where(session_states.c.state.in_(states)).order_by(sessions.c.id)
        return await self._each(query, self._read)

    async def with_ballbar(self, *, simulated: bool) -> list[int]:
        """Return the ballbar sessions of a simulated cell, or of a real one, newest first."""
        query = select(sessions.c.id).where(
            sessions.c.role == "ballbar", in_cell(sessions.c.setup, simulated=simulated)
        )
        return await self._values(query.order_by(sessions.c.id.desc()))

    async def has_finished(self, robot: str, serial_number: str) -> bool:
        """Whether a real session of this robot has finished."""
        cell = sessions.c.setup
        one = (
            select(sessions.c.id)
            .join(session_states, session_states.c.session_id == sessions.c.id)
            .where(session_states.c.state == SessionState.FINISHED.value, ~is_simulated(cell))
            .where(text_at(cell, "$.cell.robot.name") == robot)
            .where(func.coalesce(text_at(cell, "$.cell.robot_serial_number"), "") == serial_number)
        )
        return bool(await self._value(select(one.exists())))

    async def plan(self, session_id: int) -> SessionPlan:
        """Return what the session does, with what was added to it; raises NotFoundError, ConflictError."""
        role = (await self.get(session_id)).role
        if role == "ballbar":
            raise ConflictError(
                f"Session {session_id} is a ballbar session; its steps are at sessions/{session_id}/plan."
            )
        if role == "contacts":
            raise ConflictError(
                f"Session {session_id} is a closed-loop session; its plan is at sessions/{session_id}/plan."
            )
        document = await self._content(sessions.c.plan, session_id)
        # A plan has up to 5,000 stops; read on the loop it would hold up the samples of a session under way.
        plan = await asyncio.to_thread(from_document, SessionPlan, document)
        added = await self._database.read(lambda c: stops_added_to(c, session_id))
        return dataclasses.replace(plan, stops=plan.stops + added)

    async def ballbar_plan(self, session_id: int) -> BallbarPlan:
        """Return what a ballbar session does; raises NotFoundError."""
        return from_document(BallbarPlan, await self._content(sessions.c.plan, session_id))

    async def contact_plan(self, session_id: int) -> ContactPlan:
        """Return what a session of closed loops does; raises NotFoundError."""
        return from_document(ContactPlan, await self._content(sessions.c.plan, session_id))

    async def setup(self, session_id: int) -> SessionSetup:
        """Return what the session is measured with; raises NotFoundError."""
        return from_document(SessionSetup, await self._content(sessions.c.setup, session_id))

    async def states(self, session_id: int) -> list[StateChange]:
        """Return every state that the session was in, oldest first."""
        table = session_states
        query = select(table).where(table.c.session_id == session_id).order_by(table.c.id)
        return await self._each(query, partial(from_row, StateChange))

    async def additions(self, session_id: int) -> list[AdditionRecord]:
        """Return who added configurations to the plan, oldest first."""
        return await self._database.read(lambda c: additions_to(c, session_id))

    async def skipped(self, session_id: int) -> list[StopSkipped]:
        """Return what was not measured, oldest first."""
        query = _lines(session_id, EntryKind.SKIPPED).order_by(session_entries.c.id)
        lines = await self._values(query)
        stops = ((config_of(line["step_id"]), line) for line in lines)
        return [
            StopSkipped(config, line["time_s"], text_from(line.get("text", "")))
            for config, line in stops
            if config is not None
        ]

    async def registration(self, session_id: int) -> Registration | None:
        """Return the tracker's place as last registered."""
        document = session_entries.c.document
        placed = _lines(session_id, EntryKind.COMPUTED).where(is_object_at(document, "$.registration"))
        newest = placed.order_by(session_entries.c.id.desc()).limit(1)
        line = await self._value(newest)
        return None if line is None else from_document(Registration, line["registration"])

    async def identities(self, session_id: int) -> list[IdentityTaken]:
        """Return which devices answered and who accepted them, oldest first."""
        told = (events.c.session_id == session_id) & (events.c.kind == IDENTITY)
        query = select(events.c.document).where(told).order_by(events.c.id)
        return [from_document(IdentityTaken, document) for document in await self._values(query)]

    async def note(self, session_id: int, text: Text) -> None:
        """Keep a sentence."""
        await self._database.write(lambda c: add_note(c, session_id, text))

    async def notes(self, session_id: int) -> list[Text]:
        """Return the sentences kept, oldest first."""
        query = select(notes.c.text).where(notes.c.session_id == session_id).order_by(notes.c.id)
        return await self._values(query)

    async def progress(self, session_id: int) -> Progress | None:
        """Return how far the session was when it last said so."""
        told = (events.c.session_id == session_id) & (events.c.kind == PROGRESS)
        query = select(events.c.document).where(told).order_by(events.c.id.desc()).limit(1)
        document = await self._value(query)
        return None if document is None else from_document(Progress, document)


def _lines(session_id: int, kind: EntryKind) -> Select[tuple[Any]]:
    entry = session_entries.c
    return select(entry.document).where(entry.session_id == session_id, entry.kind == kind.value)


@cache
def _records() -> Select[Any]:
    # Made once: to put it together takes longer than the database takes to answer it.
    later = session_states.alias("later")
    # The newest state is the one that no later one follows: states need not be sorted for it.
    newest = ~exists().where(later.c.session_id == sessions.c.id, later.c.id > session_states.c.id)
    return (
        select(
            sessions.c.id,
            sessions.c.recorded_at,
            sessions.c.name,
            sessions.c.role,
            session_states.c.state,
            session_states.c.reason,
            session_states.c.person,
            session_states.c.recorded_at.label("state_since"),
            _planned().label("planned"),
            _measured().label("measured"),
            _skipped().label("skipped"),
            simulated_session(),
            # Only this of the plan: a list must not read whole plans.
            text_at(sessions.c.plan, "$.test").label("test"),
        )
        .join(session_states, session_states.c.session_id == sessions.c.id)
        .where(newest)
    )


def _planned() -> ColumnElement[int]:
    added = (
        select(func.coalesce(func.sum(length_at(added_stops.c.document)), 0))
        .where(added_stops.c.session_id == sessions.c.id)
        .scalar_subquery()
    )
    placements = entries_at(sessions.c.plan, "$.placements").table_valued("value")
    poses = select(func.sum(length_at(placements.c.value, "$.poses"))).scalar_subquery()
    stops = length_at(sessions.c.plan, "$.stops") + added
    return _by_role(poses, stops)


def _measured() -> ColumnElement[int]:
    # Each reading that supersedes one takes its place; the index has all that is counted.
    points = (
        select(func.count() - func.count(readings.c.supersedes))
        .where(readings.c.session_id == sessions.c.id, readings.c.kind == "point")
        .scalar_subquery()
    )
    stops = (
        select(func.count())
        .where(session_entries.c.session_id == sessions.c.id, session_entries.c.kind == "measured")
        .scalar_subquery()
    )
    return case((sessions.c.role == "contacts", stops), else_=_by_role(measured_poses(), points))


def _skipped() -> ColumnElement[int]:
    entry = session_entries.c
    of_stops = (entry.session_id == sessions.c.id, entry.kind == EntryKind.SKIPPED.value)
    stops = select(func.count()).where(*of_stops, entry.step_id.startswith("stop-")).scalar_subquery()
    return _by_role(skipped_poses(), stops)


def _by_role(ballbar: Any, points: Any) -> ColumnElement[int]:
    return case((sessions.c.role == "ballbar", ballbar), else_=points)
