"""Campaigns, and the import wizard: dropped files, how they were understood, what is made of them."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from http import HTTPStatus
from typing import Any, Final, get_args

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.exchange.import_wizard.dialogue import Asked, DetectedFile, Question, Understood
from truepose.exchange.import_wizard.headings import AXES, QUANTITIES, ColumnMeaning
from truepose.exchange.robots.named import list_robots, load_robot
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import message
from truepose.storage.drafts import Draft
from truepose.storage.records import JobKind
from truepose.storage.results.items import WorkKind
from truepose.web.pages.records import record_at, trail_of
from truepose.web.pages.rendering import MissingPageError, Visited

router = APIRouter(include_in_schema=False)
_CALLED: Final = {
    "joint": "bring.is.joint",
    "position": "bring.is.position",
    "nest": "bring.is.nest",
    "config": "bring.is.config",
    "direction": "bring.is.direction",
    "torque": "bring.is.torque",
    "time": "bring.is.time",
    "temperature": "bring.is.temperature",
    "uncertainty": "bring.is.uncertainty",
    "attachment": "bring.is.attachment",
    "qw": "bring.is.qw",
    "qx": "bring.is.qx",
    "qy": "bring.is.qy",
    "qz": "bring.is.qz",
    "length": "bring.is.length",
    "base_point": "bring.is.base_point",
    "tool_point": "bring.is.tool_point",
    "placement": "bring.is.placement",
    "init": "bring.is.init",
    "repeat_of": "bring.is.repeat_of",
    "group": "bring.is.group",
    "rotation_uncertainty": "bring.is.rotation_uncertainty",
    "uncertainty_along": "bring.is.uncertainty_along",
    "uncertainty_across": "bring.is.uncertainty_across",
    "nothing": "bring.is.nothing",
}
_CERTAINTY: Final = {
    "certain": "bring.certain",
    "likely": "bring.likely",
    "guess": "bring.guess",
    "said": "bring.said",
}
_ROLES: Final = {
    "calibration": "bring.role.calibration.choice",
    "validation": "bring.role.validation.choice",
    "legs": "bring.role.legs.choice",
    "validation_legs": "bring.role.validation_legs.choice",
    "nothing": "bring.role.nothing.choice",
}
_KINDS: Final = {"robot": "bring.file.robot", "description": "bring.file.description"}
_JOBS: Final = {JobKind.IDENTIFICATION: "bring.job.identification", JobKind.DIAGNOSIS: "bring.job.diagnosis"}
# Questions that stay where they are once they are answered: what stands below them would else move under the
# finger that is on its way there, and an answer can be changed.
_ANSWERED: Final[Mapping[str, Question]] = {
    "u_mm": Question("uncertainty", message("bring.ask.uncertainty")),
    "measured_on": Question("day", message("bring.ask.day")),
}
_ORDER: Final = get_args(Asked)
_JOINTS: Final = 7  # that a list offers; more are chosen through the interface for programs


@dataclass(frozen=True, slots=True)
class Choice:
    """Something that a list offers."""

    value: str  # what is sent if it is chosen, as JSON
    name: str


@dataclass(frozen=True, slots=True)
class AcceptedChange:
    """A change that somebody accepted, and what takes it back."""

    sentence: str
    without: str


@router.get("/bring", response_class=HTMLResponse)
async def bring_page(visit: Visited) -> HTMLResponse:
    """Show where files are dropped, and what nobody has finished yet."""
    drafts = [
        draft for draft in await visit.here.draft_desk.all() if draft.files and draft.campaign_id is None
    ]
    return visit.page("bring/bring.html", drafts=drafts)


@router.get("/bring/{id}", response_class=HTMLResponse)
async def draft_page(visit: Visited, id: str) -> HTMLResponse:
    """Show how files were understood, and what is to be done next: a fault, a question, or to begin."""
    try:
        draft = await record_at(id, visit.here.draft_desk.get)
    except MissingPageError:
        return visit.page("bring/no_draft.html", HTTPStatus.NOT_FOUND)
    found = await visit.here.draft_desk.understood(draft)
    jobs = [await visit.here.jobs.get(number) for number in draft.job_ids]
    return visit.page(
        "bring/draft.html",
        draft=draft,
        found=found,
        questions=_questions(draft, found),
        jobs=jobs,
        lost=[job for job in jobs if job.state.final and job.result_id is None],
        robots=_robots(),
        roles=_ROLES,
        kinds=_KINDS,
        certainty=_CERTAINTY,
        called_jobs=_JOBS,
        meanings=_meanings(visit.words),
        quantities=QUANTITIES,
        called=lambda meaning: _called(meaning, visit.words),
        accepted=_accepted(draft, visit.words),
        offered=_offered(draft, found),
        said=_said,
        sent=_sent,
        numbers=_numbers(draft, found.files),
    )


def _questions(draft: Draft, found: Understood) -> list[Question]:
    """Return what is asked, and what was and somebody answered, in the order in which it is asked."""
    answered = [question for name, question in _ANSWERED.items() if draft.choices.get(name) is not None]
    return sorted([*found.questions, *answered], key=lambda question: _ORDER.index(question.about))


def _robots() -> list[Choice]:
    return [Choice(name, load_robot(name).name) for name in list_robots()]


def _meanings(words: Catalogue) -> list[Choice]:
    """Return everything that a column can be."""
    return [Choice(_sent(meaning), _called(meaning, words)) for meaning in _every_meaning()]


def _sent(meaning: ColumnMeaning) -> str:
    """Return a meaning as requests have it: with a number and a unit only where it has one."""
    return _said({name: value for name, value in asdict(meaning).items() if value})


def _every_meaning() -> Iterator[ColumnMeaning]:
    last = {"joint": _JOINTS, "axis": len(AXES)}
    for name, quantity in QUANTITIES.items():
        unit = next(iter(quantity.units), "")
        for number in range(1, last[quantity.numbered] + 1) if quantity.numbered else (0,):
            yield ColumnMeaning(name, number, unit)


def _called(meaning: ColumnMeaning, words: Catalogue) -> str:
    axis = AXES[meaning.number - 1] if meaning.quantity == "position" else ""
    name = words.say(_CALLED[meaning.quantity], number=meaning.number, axis=axis)
    return f"{name}, {words.say('bring.point', number=meaning.point)}" if meaning.point else name


def _said(document: Any) -> str:
    return json.dumps(document, ensure_ascii=False)


def _offered(draft: Draft, found: Understood) -> str:
    """Return what accepts the changes that are offered, beside those that were accepted before."""
    if found.robot is None or not found.robot.offered:
        return ""
    changes = [
        {"kind": one.kind, "first": one.first, "second": one.second, "amount": one.amount}
        for one in found.robot.offered
    ]
    return _said({"robot": found.robot.key, "changes": [*draft.choices.get("changes", ()), *changes]})


def _accepted(draft: Draft, words: Catalogue) -> list[AcceptedChange]:
    from truepose.identification.verdict.conventions import Change

    changes = draft.choices.get("changes", [])
    left = [_said({"changes": changes[:at] + changes[at + 1 :]}) for at in range(len(changes))]
    said = [words.spoken(Change(**one).sentence) for one in changes]
    return [AcceptedChange(sentence, without) for sentence, without in zip(said, left, strict=True)]


def _numbers(draft: Draft, files: tuple[DetectedFile, ...]) -> dict[str, int]:
    """Return the number under which a file is kept, by its name; those of archives have none."""
    kept = {file.name.rsplit("/", 1)[-1]: file.number for file in draft.files}
    return {file.name: kept[file.name] for file in files if file.name in kept}


_COUNTS = {
    "calibration_points": "campaign.calibration_points",
    "validation_points": "campaign.validation_points",
    "calibration_legs": "campaign.calibration_legs",
    "validation_legs": "campaign.validation_legs",
    "calibration_contacts": "campaign.calibration_contacts",
    "validation_contacts": "campaign.validation_contacts",
    "reference_readings": "campaign.reference_readings",
}


@router.get("/campaigns/{id}", response_class=HTMLResponse)
async def campaign_page(visit: Visited, id: str) -> HTMLResponse:
    """Show a campaign."""
    record = await record_at(id, visit.here.campaigns.get)
    counts = [(key, getattr(record.summary, name)) for name, key in _COUNTS.items()]
    trail = await trail_of(visit, WorkKind.CAMPAIGN, record.id)
    return visit.page("campaign.html", record=record, counts=[one for one in counts if one[1]], trail=trail)
