"""Overview queries of a plant: the newest of each robot, collected campaigns, what came in lately."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from datetime import date
from functools import partial
from typing import Any, Final, TypeAlias

from sqlalchemy import ColumnElement, Connection, Row, ScalarSelect, func, select

from truepose.storage.database import Database
from truepose.storage.documents import from_json
from truepose.storage.errors import DamagedDatabaseError
from truepose.storage.plant.outbox import from_typed_json
from truepose.storage.plant.queries import (
    ResultRecord,
    cells_of_branches,
    last_before,
    last_days,
    result_seen,
    results_seen,
    with_cells,
    with_last_days,
)
from truepose.storage.plant.records import Document, day_said
from truepose.storage.plant.result_projections import ToldKind
from truepose.storage.plant.tables import (
    plant_branches,
    plant_cells,
    plant_journal,
    plant_results,
    plant_robots,
    plant_sessions,
    plant_told,
)
from truepose.storage.queries import Repository
from truepose.storage.results.items import FAILED, NO_LIMIT, PASSED, WORSE

_KINDS: Final[tuple[ToldKind, ...]] = ("campaign", "model", "validation", "diagnosis", "identification")
_EVERY: Final = plant_told.alias("every")
_STATES: Final[tuple[ToldKind, ...]] = ("model", "validation", "diagnosis", "identification")


@dataclass(frozen=True, slots=True)
class ResultFacts:
    """What a result tells, and where it stands."""

    id: int
    branch_id: int
    cell: str
    kind: ToldKind
    record_id: int  # its number in the cell
    robot_serial_number: str
    measured_on: str
    verdict: str
    figure_mm: float | None
    limit_mm: float | None
    document: Document

    def is_later_than(self, other: "ResultFacts") -> bool:
        """Whether it was measured later, or told later of the same day."""
        return (self.measured_on, self.id) > (other.measured_on, other.id)


NewestTold: TypeAlias = Mapping[str, Mapping[ToldKind, ResultFacts]]  # by robot


@dataclass
class _Before:
    """What was known when a day began; of whom nothing was, what had been measured by then."""

    day: str = ""
    known_up_to: int = 0  # number of a row
    read_up_to: int = 0
    found: dict[str, dict[ToldKind, ResultFacts]] = field(default_factory=lambda: defaultdict(dict))

    def add(self, last: int, came: Iterable[ResultFacts]) -> None:
        """Add what came in later and had been measured by then, where nothing was known."""
        self.read_up_to = max(self.read_up_to, last)
        for told in came:
            known = self.found.get(told.robot_serial_number, {}).get(told.kind)
            is_newer = known is None or (known.id > self.known_up_to and told.is_later_than(known))
            if told.measured_on < self.day and is_newer:
                self.found[told.robot_serial_number][told.kind] = told


class PlantResults(Repository):
    """All queries about what results tell.

    What was told never changes: the newest of each robot is read once a day, and then only what came since.
    """

    def __init__(self, database: Database) -> None:
        super().__init__(database)
        self._before = _Before()
        self._day = ""  # up to which what follows counts
        self._newest: defaultdict[str, dict[ToldKind, ResultFacts]] = defaultdict(dict)
        self._read_up_to = 0  # number of a row

    @property
    def read_up_to(self) -> int:
        """The last row that `newest` has read, of all that were told."""
        return self._read_up_to

    async def before(self, since: date) -> NewestTold:
        """Return the newest of each kind of every robot as it was known when a day began.

        Of whom nothing was known then, what had been measured by then: a plant that is new has collected the
        records of years in an hour.
        """
        day, before = since.isoformat(), self._before
        if day != before.day:
            self._before = await self._database.read(partial(_known_before, day=day))
        else:
            # What came since the day was read the last time, of whichever robot: looking at the last row of
            # robots alone went through all later ones at every page (commit 261c0276).
            number = before.read_up_to
            queries = [_above(number)]
            before.add(*await self._database.read(partial(_came_after, number=number, queries=queries)))
        return self._before.found

    async def newest(self, upto: date) -> NewestTold:
        """Return the newest of each kind of every robot that has any, by serial number.

        It is one up to a day, and a later one where there is no other.
        """
        day = upto.isoformat()
        # With 1,000 robots the first page took 350 ms where all was read each time, and takes 2 ms so (commit
        # 3dda84ea).
        after = self._read_up_to if day == self._day else 0
        queries = [_above(after)] if after else [_newest_of(kind, day) for kind in _KINDS]
        last, came = await self._database.read(partial(_came_after, number=after, queries=queries))
        if after == 0:
            self._newest, self._day, self._read_up_to = defaultdict(dict), day, 0
        for told in came:
            of_robot = self._newest[told.robot_serial_number]
            before = of_robot.get(told.kind)
            if before is None or _counts_before(told, before, day):
                of_robot[told.kind] = told
        # Two pages may ask at once; the later answer must not put the place back.
        self._read_up_to = max(self._read_up_to, last)
        return self._newest

    async def of_robot(self, serial_number: str, limit: int = 500) -> list[ResultFacts]:
        """Return what the latest results of a robot tell that have a day, the oldest first."""
        return await self._database.read(lambda connection: _of_robot(connection, serial_number, limit))


def _of_robot(connection: Connection, serial_number: str, limit: int) -> list[ResultFacts]:
    own = (plant_told.c.robot_serial_number == serial_number) & (plant_told.c.measured_on > "")
    query = select(plant_told, plant_cells.c.name.label("cell")).select_from(with_cells(plant_told))
    last_first = (plant_told.c.measured_on.desc(), plant_told.c.id.desc())
    rows = connection.execute(query.where(own).order_by(*last_first).limit(limit))
    return [one for one in map(result_figures, rows) if one.measured_on][::-1]


def _counts_before(told: ResultFacts, other: ResultFacts, upto: str) -> bool:
    """Whether one counts as the newest before another: up to a day, the later one."""
    # A day that is yet to come is a clock that was wrong once: it counts only where a robot has no other
    # (commit 3dbd1d75).
    due, other_due = told.measured_on <= upto, other.measured_on <= upto
    return told.is_later_than(other) if due == other_due else due


def _came_after(connection: Connection, number: int, queries: Iterable[Any]) -> tuple[int, list[ResultFacts]]:
    """Return the number of the last row, and what queries find; nothing where none is above a number."""
    last = _last_row(connection)
    rows = (row for query in queries if last > number for row in connection.execute(query))
    return last, [result_figures(row) for row in rows]


def _above(number: int) -> Any:
    of_a_robot = plant_told.c.kind.in_(_KINDS) & (plant_told.c.robot_serial_number != "")
    query = select(plant_told, plant_cells.c.name.label("cell")).select_from(with_cells(plant_told))
    return query.where(plant_told.c.id > number, of_a_robot)


def _newest_of(kind: ToldKind, upto: str) -> Any:
    return _chosen(_last_of(kind, _EVERY.c.measured_on <= upto), _last_of(kind))


def _last_row(connection: Connection) -> int:
    return int(connection.scalar(select(func.max(plant_told.c.id))) or 0)


def _known_before(connection: Connection, day: str) -> _Before:
    before = _Before(day, last_before(connection, plant_told, day), _last_row(connection))
    for kind in _STATES:
        known = _last_of(kind, _EVERY.c.id <= before.known_up_to, _EVERY.c.measured_on <= day)
        query = _chosen(known, _last_of(kind, _EVERY.c.measured_on < day))
        for row in connection.execute(query):
            before.found[row.robot_serial_number][kind] = result_figures(row)
    return before


def _last_of(kind: ToldKind, *conditions: ColumnElement[bool]) -> ScalarSelect[int]:
    """Return the number of the last that results of a kind tell of a robot."""
    own = (_EVERY.c.robot_serial_number == plant_robots.c.serial_number, _EVERY.c.kind == kind)
    query = select(_EVERY.c.id).where(*own, *conditions)
    return query.order_by(_EVERY.c.measured_on.desc(), _EVERY.c.id.desc()).limit(1).scalar_subquery()


def _chosen(*choices: Any) -> Any:
    """Return the query for what is told of every robot: the first choice that there is."""
    newest = func.coalesce(*choices)
    return select(plant_told, plant_cells.c.name.label("cell")).select_from(
        with_cells(plant_told).join(plant_robots, plant_told.c.id == newest)
    )


def result_figures(row: Row[Any]) -> ResultFacts:
    """Return what a result tells as it was read."""
    seen = {name: getattr(row, name) for name in ResultFacts.__dataclass_fields__}
    verdict = _WITHOUT_LIMIT.get(row.verdict) if row.document.get("promised") else None
    return ResultFacts(**{
        **seen,
        "measured_on": day_said(row.measured_on),
        "verdict": verdict or row.verdict,
    })


_WITHOUT_LIMIT: Final = {PASSED: NO_LIMIT, FAILED: WORSE}  # of what was collected before it was told apart


_RECORD: Final = "campaigns"


class CollectedCampaigns(Repository):
    """All queries about campaigns in the journals of cells."""

    async def all(self, robot: str | None = None) -> list[ResultRecord]:
        """Return the campaigns of all robots, or of a type, in the order in which they were collected."""
        query = results_seen().where(plant_results.c.kind == "campaign").order_by(plant_results.c.id)
        if robot is not None:
            query = query.where(plant_results.c.robot == robot)
        return await self._each(query, result_seen)

    async def content(self, campaign: ResultRecord) -> bytes:
        """Return a campaign as its cell has stored it; raises DamagedDatabaseError where it is not there."""
        here = plant_journal.c.branch_id == campaign.branch_id
        of_it = (plant_journal.c.record == _RECORD) & (plant_journal.c.record_id == campaign.record_id)
        query = select(plant_journal.c.content).where(here, of_it)
        text = await self._value(query)
        row = {} if text is None else from_typed_json(from_json(text))
        found = row.get("campaign")
        if not isinstance(found, bytes):
            raise DamagedDatabaseError(
                f"Campaign {campaign.record_id} of {campaign.cell} came without its readings; "
                "'truepose verify' shows what else is damaged."
            )
        return found


@dataclass(frozen=True, slots=True)
class RobotMeasured:
    """A robot, and when and where it was measured last."""

    serial_number: str
    robot: str  # its type
    last_measured_on: str  # a day, by the cell's clock; empty: never
    cell: str  # where that was, or where it is to be measured; empty: nobody said it
    instrument_serial_number: str = ""  # that measured it then; empty: nobody said it


@dataclass(frozen=True, slots=True)
class RecentArrivals:
    """What came in since a day began, by the plant's clock."""

    robots: int  # seen for the first time
    results: dict[str, int]  # how many of each kind
    newest: list[ResultRecord]  # the latest of them, newest first


class PlantOverview(Repository):
    """All queries about a plant as a whole."""

    async def robots(self, upto: date) -> list[RobotMeasured]:
        """Return every robot with its last day up to one; a later one where it has no other.

        A clock that was wrong once would else be the last that anybody heard of a robot.
        """
        return await self._database.read(lambda connection: _robots(connection, upto.isoformat()))

    async def robot(self, serial_number: str, upto: date) -> list[RobotMeasured]:
        """Return one robot, as it stands among them all; none where nobody has heard of it."""
        one = plant_robots.c.serial_number == serial_number
        return await self._database.read(lambda connection: _robots(connection, upto.isoformat(), one))

    async def lately(self, since: date, limit: int) -> RecentArrivals:
        """Return what came in since a day began."""
        return await self._database.read(lambda connection: _lately(connection, since.isoformat(), limit))

    async def campaigns_above(self, robot: str, number: int) -> int:
        """Return how many campaigns of a type of robot were collected after one."""
        here = (plant_results.c.kind == "campaign") & (plant_results.c.id > number)
        query = select(func.count()).select_from(plant_results).where(here, plant_results.c.robot == robot)
        return await self._value(query) or 0

    async def newest_branches(self) -> dict[str, int]:
        """Return the branch of each cell that its own numbers are those of."""
        query = (
            select(plant_cells.c.name, func.max(plant_branches.c.id))
            .join(plant_branches, plant_branches.c.cell_id == plant_cells.c.id)
            .group_by(plant_cells.c.name)
        )
        return dict(tuple(row) for row in await self._rows(query))


def _robots(connection: Connection, upto: str, *conditions: ColumnElement[bool]) -> list[RobotMeasured]:
    query = select(plant_robots.c.serial_number, plant_robots.c.robot, *last_days(plant_robots, upto))
    robots = [
        RobotMeasured(
            row.serial_number, row.robot, last.measured_on, last.cell, last.instrument_serial_number
        )
        for row, last in with_last_days(connection, query.where(*conditions), upto)
    ]
    return _where_planned(connection, robots)


def _where_planned(connection: Connection, robots: list[RobotMeasured]) -> list[RobotMeasured]:
    """Return robots with the cell that planned for them, where none has measured them."""
    unmeasured = {robot.serial_number for robot in robots if not robot.cell}
    if not unmeasured:
        return robots
    cells = cells_of_branches(connection)
    planned = select(plant_sessions.c.robot_serial_number, plant_sessions.c.branch_id)
    rows = connection.execute(planned.order_by(plant_sessions.c.id))
    places = {serial: cells[branch] for serial, branch in rows if serial in unmeasured}
    return [replace(robot, cell=robot.cell or places.get(robot.serial_number, "")) for robot in robots]


def _lately(connection: Connection, since: str, limit: int) -> RecentArrivals:
    before = last_before(connection, plant_results, since)
    recent = plant_results.c.id > before
    counts = select(plant_results.c.kind, func.count()).where(recent).group_by(plant_results.c.kind)
    newest = results_seen().where(recent).order_by(plant_results.c.id.desc()).limit(limit)
    robots_before = last_before(connection, plant_robots, since)
    robots = select(func.count()).select_from(plant_robots).where(plant_robots.c.id > robots_before)
    return RecentArrivals(
        robots=connection.scalar(robots) or 0,
        results=dict(tuple(row) for row in connection.execute(counts)),
        newest=[result_seen(row) for row in connection.execute(newest)],
    )
