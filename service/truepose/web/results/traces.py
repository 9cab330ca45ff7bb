"""The conditions that a session recorded, and the records that a result rests on."""

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from pydantic import BaseModel

from truepose.domain.cell.artefacts import Artefact, BallbarKit
from truepose.domain.cell.description import Cell
from truepose.domain.measurement.ballbar import BallbarPlan
from truepose.domain.measurement.identities import IdentityTaken
from truepose.domain.measurement.session import SessionPlan, SessionState
from truepose.domain.sentences import said
from truepose.exchange.models.file import model_text
from truepose.storage.records import ModelRecord, SessionSetup, StateChange
from truepose.web.context import Context
from truepose.web.results.kinds import Origin
from truepose.web.visiting.moments import moment
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.traceability.audit import Audit
    from truepose.reports.traceability.certified_lengths import LengthOfDay
    from truepose.reports.traceability.conditions import Instrument, ReportConditions
    from truepose.reports.traceability.traced import Traced

_ROLES: Final = {"tracker": "laser tracker", "robot": "robot controller", "ballbar": "ballbar"}
_MOVING: Final = SessionState.RUNNING


@dataclass(frozen=True, slots=True)
class Shown:
    """A result as a document, and where that is."""

    address: str
    document: BaseModel


async def traced(
    here: Context, origin: Origin, shown: Shown, model: ModelRecord | None, words: Catalogue
) -> "Traced":
    """Return what a result of a session ends with."""
    from truepose.reports.traceability.traced import Traced

    setup = await here.sessions.setup(origin.record.id)
    conditions = await session_conditions(here, origin, words)
    return Traced(setup.cell.robot.name, conditions, await _audit(here, origin, shown, model))


async def _audit(here: Context, origin: Origin, shown: Shown, model: ModelRecord | None) -> "Audit":
    from truepose.reports.traceability.audit import Audit

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
    return document.model_dump_json(by_alias=True)


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


async def session_conditions(here: Context, origin: Origin, words: Catalogue) -> "ReportConditions":
    """Return the conditions that a session recorded."""
    from truepose.reports.traceability.conditions import Period, ReportConditions

    number, setup = origin.record.id, await here.sessions.setup(origin.record.id)
    cell = setup.cell
    registration = await here.sessions.registration(number)
    states, identities = await here.sessions.states(number), await here.sessions.identities(number)
    stated = ReportConditions(
        simulated=setup.simulated,
        instruments=tuple(_instruments(here, setup, identities)),
        artefacts=tuple(_artefacts(cell, by_bar=origin.record.role == "ballbar")),
        robot_serial_number=cell.robot_serial_number,
        person=", ".join(_people(states)),
        written_at=moment(datetime.now(UTC).isoformat()),
        load=cell.conditions.load,
        warm_up=cell.conditions.warm_up,
        temperature_c=await _temperatures(here, number),
        part_temperature_c=cell.conditions.part_temperature_c,
        sessions=(Period(origin.record.name, _began(states), moment(origin.record.state_since)),),
        two_face_mm=None if registration is None else registration.two_face_mm,
        registration_rms_mm=None if registration is None else registration.rms_mm,
        scale=None if registration is None else registration.scale,
        scale_standard_uncertainty=None if registration is None else registration.scale_standard_uncertainty,
        notes=tuple(await here.sessions.notes(number)),
    )
    return await _with_plan(here, origin, replace(stated, **await _lengths(here, origin, stated)), words)


async def _lengths(here: Context, origin: Origin, stated: "ReportConditions") -> dict[str, Any]:
    """Return what certified lengths the session rests on, and at which temperatures they were used."""
    cell = (await here.sessions.setup(origin.record.id)).cell
    if origin.record.role != "ballbar":
        return {"lengths": tuple(_between_nests(cell, stated.temperature_c))}
    at_bar = await _temperatures_at_bar(here, origin.record.id)
    return {"instrument_temperature_c": at_bar, "lengths": tuple(_calibrators(cell, at_bar))}


def _between_nests(cell: Cell, warmth: tuple[float, float] | None) -> "Iterator[LengthOfDay]":
    from truepose.reports.traceability.certified_lengths import LengthOfDay

    for one in cell.certified_lengths:
        first, second = one.fixed_nests
        between = said("lengths.between_nests", first=first, second=second)
        yield LengthOfDay(between, one.length_mm, one.standard_uncertainty_mm, one.expansion_per_k, warmth)


def _calibrators(cell: Cell, warmth: tuple[float, float] | None) -> "Iterator[LengthOfDay]":
    from truepose.reports.traceability.certified_lengths import LengthOfDay

    kit = cell.ballbar or BallbarKit()
    for bars in dict.fromkeys((kit.tool_bars, kit.base_bars)):
        of = said("lengths.calibrator", name=kit.calibrator.name, nominal_mm=bars.nominal_mm)
        yield LengthOfDay(of, bars.calibrator_mm, bars.calibrator_u_mm, bars.expansion_per_k, warmth)


async def _with_plan(
    here: Context, origin: Origin, stated: "ReportConditions", words: Catalogue
) -> "ReportConditions":
    if origin.record.role == "ballbar":
        by_bar = await here.sessions.ballbar_plan(origin.record.id)
        return replace(stated, **_speeds(by_bar))
    plan = await here.sessions.plan(origin.record.id)
    approach = _approach(plan.approach_offset_rad, words)
    return replace(stated, approach=approach, measure_s=plan.measure_s, **_speeds(plan))


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
    from truepose.reports.traceability.conditions import Instrument

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


async def _temperatures(here: Context, session_id: int) -> tuple[float, float] | None:
    taken = [point.temperature_c for point in await here.readings.points(session_id)]
    known = [celsius for celsius in taken if np.isfinite(celsius)]
    return (min(known), max(known)) if known else None


async def _temperatures_at_bar(here: Context, session_id: int) -> tuple[float, float] | None:
    lines = await here.session_desk.ledger.whole(session_id)
    taken = [line.entry.length.temperature_c for line in lines if line.entry.length is not None]
    known = [celsius for celsius in taken if np.isfinite(celsius)]
    return (min(known), max(known)) if known else None
