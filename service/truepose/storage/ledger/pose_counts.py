"""How many poses a ballbar session has measured and left out, from its ledger.

Left out are those of which the newest word is a skip: not one that was measured at a later attempt, nor one
whose skip was taken back. One that the next pre-calibration offers again is open, until it is skipped anew.
It is what the situation of a session counts, which replays the whole ledger: a list of sessions cannot.
"""

from typing import Any, Final

from sqlalchemy import ColumnElement, String, and_, cast, exists, false, func, or_, select

from truepose.storage.engine.dialects import is_object_at, leading_number, position_of
from truepose.storage.tables import session_entries, sessions

_POSE: Final = "/pose-"
# `MAX_ATTEMPTS` of the agenda is three, and attempts are numbered from the second on: "/again" is the second,
# "/again-2" the third. A test holds this count against the situation on random ledgers.
_LAST_ATTEMPT: Final = "%/again-2/%"  # after the third nothing is offered again


def measured_poses() -> Any:
    """Count the poses of which a leg was measured: "placement-1/pose-12/leg-2-3" is of pose 12."""
    step = session_entries.c.step_id
    return (
        select(func.count(func.distinct(_number_of(step))))
        .where(session_entries.c.session_id == sessions.c.id, session_entries.c.kind == "measured")
        .where(step.contains(_POSE), step.contains("/leg-"))
        .scalar_subquery()
    )


def skipped_poses() -> Any:
    """Count the poses of a session, of the query around it, whose last attempt ended with a skip."""
    skip, later = session_entries.alias("skip"), session_entries.alias("later")
    pose = _pose_of(skip.c.step_id)
    newer_word = exists().where(
        later.c.session_id == skip.c.session_id,
        later.c.kind.in_(("skipped", "moved", "measured", "reopened")),
        *_begins_with(later.c.step_id, pose, "/"),
        later.c.id > skip.c.id,
        or_(later.c.kind != "reopened", later.c.step_id.not_like("%/detach")),  # which says nothing of a skip
    )
    return (
        select(func.count())
        .where(skip.c.session_id == sessions.c.id, skip.c.kind == "skipped", skip.c.step_id.contains(_POSE))
        .where(~newer_word, ~_is_offered_again(skip))
        .scalar_subquery()
    )


def _is_offered_again(skip: Any) -> ColumnElement[bool]:
    """Whether the first pre-calibration after a skip found something, and another attempt is allowed."""
    # Computed with nothing found, or skipped, offers nothing again: the agenda goes on as it was.
    found = session_entries.alias("found")
    place = func.substr(skip.c.step_id, 1, position_of(skip.c.step_id, _POSE) - 1)
    first = (
        select(is_object_at(found.c.document, "$.precalibration"))
        .where(found.c.session_id == skip.c.session_id, found.c.kind.in_(("computed", "skipped")))
        .where(*_begins_with(found.c.step_id, place, "/precalibrate-"))
        .where(found.c.id > skip.c.id)
        .order_by(found.c.id)
        .limit(1)
        .scalar_subquery()
    )
    return and_(func.coalesce(first, false()), skip.c.step_id.not_like(_LAST_ATTEMPT))


def _number_of(step: Any) -> ColumnElement[int]:
    return leading_number(func.substr(step, position_of(step, _POSE) + len(_POSE)))


def _pose_of(step: Any) -> ColumnElement[str]:
    """Return "placement-1/pose-12" of "placement-1/pose-12/again/leg-2-3"."""
    # Both engines cut texts by lengths and have no regular expression in common.
    digits = func.length(cast(_number_of(step), String))
    return func.substr(step, 1, position_of(step, _POSE) + len(_POSE) - 1 + digits)


def _begins_with(step: Any, group: Any, mark: str) -> tuple[ColumnElement[bool], ColumnElement[bool]]:
    """Compare as ranges: the index has session, kind and step."""
    next_mark = mark[:-1] + chr(ord(mark[-1]) + 1)
    return step >= group.concat(mark), step < group.concat(next_mark)
