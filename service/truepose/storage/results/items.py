"""What every kind of record has in common, and where its tables have it."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

from sqlalchemy import (
    ColumnElement,
    FromClause,
    Label,
    Row,
    Select,
    Table,
    case,
    exists,
    func,
    literal,
    or_,
    select,
)
from sqlalchemy.sql.expression import null

from truepose.storage.engine.dialects import number_at, text_at, truth_at
from truepose.storage.records import JobKind, JobState
from truepose.storage.results.campaigns import simulated_campaign, simulated_session
from truepose.storage.rows import from_row
from truepose.storage.tables import (
    campaigns,
    corrections,
    diagnoses,
    handed_down,
    identifications,
    job_states,
    jobs,
    models,
    session_states,
    sessions,
    validations,
)

PROOF: Final = "proof"  # role of a session that was planned to prove a model
TEST: Final = "test"  # and of one with the ballbar whose readings do not identify
HELD_OUT: Final = "held_out"  # role of a campaign with readings that judge a model and never identify it
# What a validation came to: by its decision about a limit, else by what its model claims.
PASSED, FAILED, UNDECIDED, NO_LIMIT, WORSE = "passed", "failed", "undecided", "no_limit", "worse"


class WorkKind(StrEnum):
    """A kind of record that people look for."""

    SESSION = "session"
    CAMPAIGN = "campaign"
    IDENTIFICATION = "identification"
    DIAGNOSIS = "diagnosis"
    MODEL = "model"
    VALIDATION = "validation"
    CORRECTION = "correction"
    JOB = "job"  # that made nothing: under way, or failed


@dataclass(frozen=True, slots=True)
class WorkItem:
    """One record in a list; what a kind does not have is empty."""

    kind: WorkKind
    id: int
    recorded_at: str
    name: str
    robot: str
    serial_number: str
    state: str  # of a session, a job; status, verdict; what the decision about a limit came to
    role: str  # what a session is for, what a job makes; empty for others
    simulated: bool


@dataclass(frozen=True, slots=True)
class Source:
    """Where one kind of record is."""

    table: Table
    joined: FromClause  # the table with what its columns come from
    columns: Mapping[str, Any]  # of `WorkItem`
    searched: tuple[Any, ...] = ()  # texts, besides what the record and its robot are called
    kept: ColumnElement[bool] | None = None  # which of its records are listed; None: all

    def numbers(self, kind: WorkKind, texts: tuple[str, ...] = ()) -> Select[Any]:
        """Return the query of kind, number and moment of the records in which one of `texts` stands."""
        # Without a search neither joins nor JSON are touched: ten thousand records are listed and counted by
        # their indices.
        origin = self.joined if texts else self.table
        query = select(literal(kind.value).label("kind"), self.table.c.id, self.table.c.recorded_at)
        query = query.select_from(origin)
        if self.kept is not None:
            query = query.where(self.kept)
        return query.where(or_(*(self._has(text) for text in texts))) if texts else query

    def _has(self, text: str) -> ColumnElement[bool]:
        is_number = text.isascii() and text.isdecimal() and len(text) < _NUMBER_DIGITS
        number = [self.table.c.id == int(text)] if is_number else []
        # Whatever somebody pastes into the field is compared with every text of every record.
        short = [one for one in (text,) if len(one) < _LONGEST]
        columns = [self.columns[name] for name in _NAMES if name in self.columns]
        found = [
            column.icontains(one, autoescape=True) for one in short for column in (*columns, *self.searched)
        ]
        # A text that is too long and no number finds nothing; an empty `or_` would find everything.
        return or_(*found, *number, literal(False))

    def items(self, kind: WorkKind, *conditions: ColumnElement[bool]) -> Select[Any]:
        """Return the query of whole items."""
        own = literal(kind.value).label("kind"), self.table.c.id, self.table.c.recorded_at
        texts: list[Label[Any]] = [self.columns.get(name, literal("")).label(name) for name in _TEXTS]
        simulated = self.columns.get("simulated", literal(False)).label("simulated")
        return select(*own, *texts, simulated).select_from(self.joined).where(*conditions)


_NAMES: Final = ("name", "robot", "serial_number")
_TEXTS: Final = (*_NAMES, "state", "role")
_LONGEST: Final = 200  # letters of what is searched for
_NUMBER_DIGITS: Final = 19  # of the largest whole number that a database compares, of 64 bits


def item_of(row: Row[Any]) -> WorkItem:
    """Return the item that a row of `Source.items` is."""
    texts = {name: str(getattr(row, name) or "") for name in _TEXTS}
    return from_row(WorkItem, row, **texts)


def _of_setup(path: str) -> ColumnElement[Any]:
    return text_at(sessions.c.setup, f"$.cell.{path}")


def _newest(table: Table, column: Any, belongs: ColumnElement[bool]) -> Any:
    return select(column).where(belongs).order_by(table.c.id.desc()).limit(1).scalar_subquery()


def _people() -> Any:
    """Every person of a session's states, in one text."""
    named = select(func.aggregate_strings(session_states.c.person, " "))
    return named.where(session_states.c.session_id == sessions.c.id).scalar_subquery()


_PROVES = exists().where(
    job_states.c.job_id == jobs.c.id,
    job_states.c.result_id == sessions.c.id,
    jobs.c.kind == JobKind.PLAN.value,
    text_at(jobs.c.request, "$.proves_model_id").is_not(None),
)
_TESTS = text_at(sessions.c.plan, "$.test").is_not(None)
_SESSIONS = Source(
    sessions,
    sessions,
    {
        "name": sessions.c.name,
        "robot": _of_setup("robot.name"),
        "serial_number": _of_setup("robot_serial_number"),
        "state": _newest(
            session_states, session_states.c.state, session_states.c.session_id == sessions.c.id
        ),
        "role": case((_PROVES, PROOF), (_TESTS, TEST), else_=sessions.c.role),
        "simulated": simulated_session(),
    },
    (_of_setup("name"), _of_setup("devices"), _people()),
)
_JUDGING = [
    number_at(campaigns.c.summary, f"$.validation_{what}") > 0 for what in ("points", "legs", "contacts")
]
_CAMPAIGNS = Source(
    campaigns,
    campaigns,
    {
        "name": campaigns.c.name,
        "robot": campaigns.c.robot,
        "serial_number": text_at(campaigns.c.summary, "$.robot_serial_number"),  # of one that was brought
        "role": case((or_(*_JUDGING), HELD_OUT), else_=""),
        "simulated": simulated_campaign(),
    },
)
_IDENTIFICATIONS = Source(
    identifications,
    identifications.join(campaigns, campaigns.c.id == identifications.c.campaign_id),
    {
        "name": campaigns.c.name,
        "robot": campaigns.c.robot,
        "state": text_at(identifications.c.document, "$.status"),
        "simulated": simulated_campaign(),
    },
)
_DIAGNOSES = Source(
    diagnoses,
    diagnoses.join(campaigns, campaigns.c.id == diagnoses.c.campaign_id).outerjoin(
        models, models.c.diagnosis_id == diagnoses.c.id
    ),
    {
        "name": campaigns.c.name,
        "robot": campaigns.c.robot,
        "serial_number": diagnoses.c.robot_serial_number,
        "state": case(
            (models.c.id.is_(None), "not_answered"), else_=text_at(diagnoses.c.summary, "$.verdict")
        ),
        "simulated": simulated_campaign(),
    },
    (text_at(diagnoses.c.summary, "$.findings"),),
)
_FOUND_BY = func.coalesce(identifications.c.campaign_id, diagnoses.c.campaign_id)


def _with_origin(joined: FromClause) -> FromClause:
    """Return models, or what is joined with them, beside the campaign or hand-down that each comes from."""
    return (
        joined
        .outerjoin(identifications, identifications.c.id == models.c.identification_id)
        .outerjoin(diagnoses, diagnoses.c.id == models.c.diagnosis_id)
        .outerjoin(campaigns, campaigns.c.id == _FOUND_BY)
        .outerjoin(handed_down, handed_down.c.id == models.c.handed_down_id)
    )


_MODELS = Source(
    models,
    _with_origin(models),
    {
        "name": func.coalesce(campaigns.c.name, handed_down.c.name),
        "robot": models.c.robot,
        "serial_number": diagnoses.c.robot_serial_number,
        "simulated": simulated_campaign(),
    },
)
_VALIDATION_STATES: Final = {
    "conforms": PASSED,
    "does not conform": FAILED,
    "cannot be decided": UNDECIDED,
}


def validation_state(document: Mapping[str, Any]) -> str:
    """Return what a stored validation came to, as lists of a cell have it."""
    verdict = (document.get("decision") or {}).get("verdict")
    if verdict in _VALIDATION_STATES:
        return _VALIDATION_STATES[verdict]
    if document["limit_mm"] is None:
        return NO_LIMIT if document["passed"] else WORSE
    return PASSED if document["passed"] else FAILED  # of a program that knew no decision rule


_decision: Final = text_at(validations.c.document, "$.decision.verdict")
_met: Final = truth_at(validations.c.document, "$.passed")
_VALIDATIONS = Source(
    validations,
    validations.join(campaigns, campaigns.c.id == validations.c.campaign_id),
    {
        "name": campaigns.c.name,
        "robot": campaigns.c.robot,
        "state": case(
            *((_decision == verdict, state) for verdict, state in _VALIDATION_STATES.items()),
            (text_at(validations.c.document, "$.limit_mm").is_(None), case((_met, NO_LIMIT), else_=WORSE)),
            (_met, PASSED),  # of a program that knew no decision rule
            else_=FAILED,
        ),
        "simulated": simulated_campaign(),
    },
)
_CORRECTIONS = Source(
    corrections,
    _with_origin(corrections.join(models, models.c.id == corrections.c.model_id)),
    {"name": corrections.c.name, "robot": models.c.robot, "simulated": simulated_campaign()},
)
_JOB_STATE = _newest(job_states, job_states.c.state, job_states.c.job_id == jobs.c.id)
_MADE = exists().where(job_states.c.job_id == jobs.c.id, job_states.c.state == JobState.SUCCEEDED.value)
_JOBS = Source(
    jobs,
    jobs,
    {
        "name": func.coalesce(text_at(jobs.c.request, "$.name"), text_at(jobs.c.request, "$.file"), null()),
        "state": _JOB_STATE,
        "role": jobs.c.kind,
    },
    (text_at(jobs.c.request, "$.file"),),
    ~_MADE,
)

SOURCES: Final[Mapping[WorkKind, Source]] = {
    WorkKind.SESSION: _SESSIONS,
    WorkKind.CAMPAIGN: _CAMPAIGNS,
    WorkKind.IDENTIFICATION: _IDENTIFICATIONS,
    WorkKind.DIAGNOSIS: _DIAGNOSES,
    WorkKind.MODEL: _MODELS,
    WorkKind.VALIDATION: _VALIDATIONS,
    WorkKind.CORRECTION: _CORRECTIONS,
    WorkKind.JOB: _JOBS,
}
