"""Corrections for people: a form that takes a program, and what each came to, at its own address."""

import asyncio
from dataclasses import dataclass
from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse
from markupsafe import Markup

from truepose.analysis.workers.correcting import MOST_TARGETS
from truepose.domain.results.corrections import CorrectedTargets
from truepose.kinematics.inverse import BRANCH_NAMES
from truepose.storage.records import CorrectionRecord
from truepose.storage.work.items import WorkKind
from truepose.web.calibration.corrections import ANGLES, corrected_name
from truepose.web.records.trail import missing, record_at, trail_of
from truepose.web.requests.parameters import WantedModel
from truepose.web.schemas.base import NUMBER_LIMIT
from truepose.web.visiting.visits import Visited
from truepose.words.catalogue import Catalogue

router = APIRouter(prefix="/corrections", include_in_schema=False)
_SHOWN: Final = 50
_ROWS: Final = 200
After = Annotated[int, Query(ge=0, le=NUMBER_LIMIT, description="Show targets behind this one.")]


@dataclass(frozen=True, slots=True)
class Shown:
    """What the page shows of a correction."""

    sentences: tuple[str, ...]
    cautions: tuple[str, ...]
    left_alone: tuple[tuple[str, str, str], ...]  # place, what, why
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    picture: Markup | None
    caption: str
    following: int | None  # behind which target the next rows stand


@router.get("", response_class=HTMLResponse)
async def corrections_page(visit: Visited, wanted: WantedModel = None) -> HTMLResponse:
    """Show the form that takes a program, and the latest corrections."""
    return visit.page(
        "results/corrections.html",
        models=await visit.here.results.newest_models(_SHOWN),
        wanted=wanted,
        branches=BRANCH_NAMES,
        angles=ANGLES,
        most=MOST_TARGETS,
        records=await visit.here.corrections.newest(_SHOWN),
        shown=_SHOWN,
    )


@router.get("/{id}", response_class=HTMLResponse)
async def correction_page(visit: Visited, id: str, after: After = 0) -> HTMLResponse:
    """Show what a file came to, with its targets."""
    record = await record_at(id, visit.here.corrections.get)
    if record is None:
        return missing(visit)
    targets = await visit.here.corrections.targets(record.id)
    shown = await asyncio.to_thread(_shown, record, targets, visit.words, after)
    return visit.page(
        "results/correction.html",
        record=record,
        shown=shown,
        saved_as=corrected_name(record.name),
        trail=await trail_of(visit, WorkKind.CORRECTION, record.id),
    )


def _shown(record: CorrectionRecord, targets: CorrectedTargets, words: Catalogue, after: int) -> Shown:
    from truepose.reports.corrected_targets import target_heads, target_rows
    from truepose.reports.corrections import correction_sentences
    from truepose.reports.figures.maps.shift_map import shift_map

    found, drawn = record.correction, shift_map(targets, words)
    following = after + _ROWS
    return Shown(
        sentences=tuple(map(words.spoken, correction_sentences(found.totals))),
        cautions=tuple(map(words.spoken, found.cautions)),
        left_alone=tuple(
            (words.spoken(one.place), one.what, words.spoken(one.reason)) for one in found.left_alone
        ),
        heads=target_heads(words),
        rows=tuple(target_rows(targets, words, after, _ROWS)),
        picture=None if drawn is None else drawn.picture,
        caption=""
        if drawn is None
        else words.say("shifts.caption", times=drawn.exaggeration, shown=drawn.shown, total=drawn.total),
        following=following if following < len(targets.names) else None,
    )
