"""Conditions and records that a result rests on, of its sessions or as an upload states; certificates."""

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from pydantic import BaseModel

from truepose.domain.ballbar import BallbarPlan
from truepose.domain.cell import Artefact, BallbarKit, Cell, Closing, judged_papers
from truepose.domain.session import IdentityTaken, Registration, SessionPlan, SessionState
from truepose.exchange.models.file import model_text
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, Text, message
from truepose.sessions.closing import papers_of_cell
from truepose.storage.records import CampaignRecord, ModelRecord, SessionSetup, StateChange
from truepose.web.context import Context
from truepose.web.pages.rendering import moment
from truepose.web.pages.session_history import acts_of_session
from truepose.web.pages.session_results import Origin, origin_of

if TYPE_CHECKING:
    from truepose.reports.traceability import Audit, Event, Instrument, LengthOfDay, ReportConditions


_ROLES: Final = {"tracker": "laser tracker", "robot": "robot controller", "ballbar": "ballbar"}
_MOVING: Final = SessionState.RUNNING


@dataclass(frozen=True, slots=True)
class ResultDocument:
    """A result as a document, and where that is."""

    address: str
    document: BaseModel


async def audit_of(
    here: Context, origin: Origin, shown: ResultDocument, model: ModelRecord | None
) -> "Audit":
    """Return the records behind a result of a session."""
    from truepose.reports.traceability import Audit

    return Audit(
        session_id=origin.record.id,
        session_sha256=await here.sessions.chain_head(origin.record.id),
        document=shown.address,
        document_sha256=_sha256(_sent(shown.document)),
        model_id=None if model is None else model.id,
        model_sha256="" if model is None else _sha256(model_text(model.model)),
    )


def _sent(document: BaseModel) -> str:
    """Return a document as the API sends it."""
    # Whoever follows the printed address and hashes what comes has to find the printed hash.
    return document.model_dump_json(by_alias=True)


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


async def session_conditions(here: Context, origin: Origin, words: Catalogue) -> "ReportConditions":
    """Return the conditions that a session recorded."""
    from truepose.reports.traceability import Period, ReportConditions

    number, by_bar = origin.record.id, here.session_desk.kind_of(origin.record).by_calibrator
    setup, states = await here.sessions.setup(number), await here.sessions.states(number)
    cell = setup.cell
    stated = ReportConditions(
        simulated=setup.simulated,
        instruments=tuple(_instruments(here, setup, await here.sessions.identities(number))),
        artefacts=tuple(_artefacts(cell, by_bar=by_bar)),
        robot_serial_number=cell.robot_serial_number,
        person=", ".join(_people(states)),
        written_at=moment(datetime.now(UTC).isoformat()),
        load=cell.conditions.load,
        warm_up=cell.conditions.warm_up,
        temperature_c=_span(point.temperature_c for point in await here.readings.points(number)),
        part_temperature_c=cell.conditions.part_temperature_c,
        sessions=(Period(origin.record.name, _began(states), moment(origin.record.state_since)),),
        notes=tuple(map(words.spoken, await here.sessions.notes(number))),
        **_registered(await here.sessions.registration(number)),
    )
    if by_bar:
        return replace(stated, **await _by_bar(here, number, cell))
    lengths = tuple(_between_nests(cell, stated.temperature_c))
    return replace(stated, lengths=lengths, **await _by_points(here, number, words))


def _registered(found: Registration | None) -> dict[str, Any]:
    """Return what the tracker's place in the world rests on."""
    if found is None:
        return {}
    return {
        "two_face_mm": found.two_face_mm,
        "registration_rms_mm": found.rms_mm,
        "scale": found.scale,
        "scale_standard_uncertainty": found.scale_standard_uncertainty,
    }


async def _by_bar(here: Context, number: int, cell: Cell) -> dict[str, Any]:
    """Return how a session with the ballbar measured, and the certified lengths that it rests on."""
    lines = await here.session_desk.ledger.whole(number)
    warmth = _span(line.entry.length.temperature_c for line in lines if line.entry.length is not None)
    plan = await here.sessions.ballbar_plan(number)
    return {
        **_speeds(plan),
        "instrument_temperature_c": warmth,
        "lengths": tuple(_calibrators(cell, warmth)),
    }


async def _by_points(here: Context, number: int, words: Catalogue) -> dict[str, Any]:
    """Return how a session with a tracker or a camera measured."""
    plan = await here.sessions.plan(number)
    return {
        **_speeds(plan),
        "approach": _approach(plan.approach_offset_rad, words),
        "measure_s": plan.measure_s,
    }


def _between_nests(cell: Cell, warmth: tuple[float, float] | None) -> "Iterator[LengthOfDay]":
    from truepose.reports.traceability import LengthOfDay

    for one in cell.certified_lengths:
        first, second = one.fixed_nests
        between = message("lengths.between_nests", first=first, second=second)
        yield LengthOfDay(between, one.length_mm, one.standard_uncertainty_mm, one.expansion_per_k, warmth)


def _calibrators(cell: Cell, warmth: tuple[float, float] | None) -> "Iterator[LengthOfDay]":
    from truepose.reports.traceability import LengthOfDay

    kit = cell.ballbar or BallbarKit()
    for bars in dict.fromkeys((kit.tool_bars, kit.base_bars)):
        of = message("lengths.calibrator", name=kit.calibrator.name, nominal_mm=bars.nominal_mm)
        yield LengthOfDay(of, bars.calibrator_mm, bars.calibrator_u_mm, bars.expansion_per_k, warmth)


def _speeds(plan: SessionPlan | BallbarPlan) -> dict[str, Any]:
    return {
        "tool_speed_mm_s": plan.tool_speed_mm_s,
        "orientation_speed_rad_s": plan.orientation_speed_rad_s,
        "settle_s": plan.settle_s,
    }


def _instruments(
    here: Context, setup: SessionSetup, identities: Iterable[IdentityTaken]
) -> "Iterator[Instrument]":
    """Yield each device that answered, with the certificate that holds for its serial number."""
    from truepose.reports.traceability import Instrument

    # By serial number, not by place in the cell: a certificate is of one instrument (decision 0020).
    papers = {entry.serial_number: entry for entry in setup.cell.devices if entry.serial_number}
    present = {status.answered_serial: status.identity for status in here.rack.statuses()}
    for device, serial in dict.fromkeys((taken.device, taken.serial) for taken in identities):
        known = present.get(serial) if serial else None  # a device that left since says no more
        yield Instrument(
            role=_ROLES[device],
            manufacturer=known.manufacturer if known else "",
            model=known.model if known else "",
            serial_number=serial,
            firmware=known.firmware if known else "",
            certificate=papers[serial].certificate if serial in papers else "",
            certificate_expires=papers[serial].certificate_expires if serial in papers else "",
        )


def _artefacts(cell: Cell, *, by_bar: bool) -> Iterator[Artefact]:
    if by_bar and cell.ballbar is not None:
        yield from (cell.ballbar.instrument, cell.ballbar.calibrator)
    yield from (artefact for artefact in (cell.tool, cell.world) if artefact is not None)


def _people(states: Iterable[StateChange]) -> Iterator[str]:
    """Yield who let the arm move, each once."""
    yield from dict.fromkeys(one.person for one in states if one.state is _MOVING and one.person)


def _began(states: Iterable[StateChange]) -> str:
    return next((moment(one.recorded_at) for one in states if one.state is _MOVING), "")


def _approach(offset_rad: float | None, words: Catalogue) -> str:
    if offset_rad is None:
        return words.say("conditions.approach.mixed")
    return words.say("conditions.approach.from", offset_deg=float(np.degrees(offset_rad)))


def _span(celsius: Iterable[float]) -> tuple[float, float] | None:
    """Return the lowest and the highest of temperatures; None where none was recorded."""
    known = [one for one in celsius if np.isfinite(one)]
    return (min(known), max(known)) if known else None


async def conditions_of_sessions(
    here: Context, numbers: Sequence[int], words: Catalogue
) -> "ReportConditions":
    """Return the conditions of the first session, with the periods, acts and closings of all."""
    each = [await session_conditions(here, await origin_of(here, number), words) for number in numbers]
    closings = [await here.closings.of_session(number) for number in numbers]
    events = [event for number in numbers for event in await acts_of_session(here, number, words)]
    first = each[0]
    return replace(
        first,
        sessions=tuple(period for one in each for period in one.sessions),
        person=", ".join(dict.fromkeys(one.person for one in each if one.person)),
        notes=tuple(dict.fromkeys(note for one in each for note in one.notes)),
        closing=_closing_of(numbers, closings),
        overridden=any(one is not None and one.overridden for one in closings),
        events=(*events, *_closed(closings)),
    )


async def conditions_of_result(
    here: Context, campaign_id: int, recorded_at: str, words: Catalogue
) -> "ReportConditions":
    """Return the conditions of the readings that a result is of, and when it was recorded."""
    campaign = await here.campaigns.get(campaign_id)
    stated = _as_stated(campaign)
    if campaign.session_ids:
        stated = await conditions_of_sessions(here, campaign.session_ids, words)
    return replace(stated, written_at=moment(recorded_at))


def _as_stated(campaign: CampaignRecord) -> "ReportConditions":
    """Return what came with an upload."""
    from truepose.reports.traceability import Instrument, ReportConditions

    told = campaign.summary
    serial, certificate = told.instrument_serial_number or "", told.certificate or ""
    known = Instrument(
        "instrument", model=told.instrument or "", serial_number=serial, certificate=certificate
    )
    return ReportConditions(
        simulated=campaign.simulated,
        instruments=(known,) if told.instrument or serial or certificate else (),
        robot_serial_number=told.robot_serial_number or "",
        person=told.measured_by or "",
        measured_at=told.measured_on or "",
        notes=told.notes,
    )


def _closing_of(numbers: Sequence[int], closings: Sequence[Closing | None]) -> Message:
    """Return what each session was closed as; a single one needs no number."""
    if len(numbers) == 1:
        return closing_sentence(closings[0])
    each = zip(numbers, map(closing_sentence, closings), strict=True)
    return message(
        "closings", sentences=tuple(message("closing.of", number=number, closing=one) for number, one in each)
    )


def closing_sentence(closing: Closing | None) -> Message:
    """Return what a session was closed as, by whom, and what was passed over."""
    if closing is None:
        return message("closing.open")
    person, day = closing.person, moment(closing.closed_at)
    if closing.closed_as == "not calibrated":
        return message("closing.not_calibrated", person=person, day=day, reason=closing.reason)
    if not closing.overridden:
        return message("closing.calibrated", person=person, day=day)
    faults = tuple(one.fault for one in closing.overridden)
    return message("closing.overridden", person=person, day=day, faults=faults, reason=closing.reason)


def _closed(closings: Sequence[Closing | None]) -> "Iterator[Event]":
    from truepose.reports.traceability import Event

    for one in closings:
        if one is not None:
            yield Event(moment(one.closed_at), one.person, closing_sentence(one))


def expiry_warnings(cell: Cell, today: date) -> Iterator[Text]:
    """Yield a sentence for each certificate that ends within thirty days, or has ended."""
    for one in judged_papers(papers_of_cell(cell), today):
        if one.standing == "ends soon":
            left = (date.fromisoformat(one.paper.expires) - today).days
            yield message("certificate.ends_soon", what=one.paper.called, day=one.paper.expires, days=left)
        elif one.standing == "expired":
            yield one.fault
