"""Under which conditions a result came about: those of its sessions, or what an upload says."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from truepose.domain.cell.certificates import Closing
from truepose.domain.sentences import Sentence, said
from truepose.web.context import Context
from truepose.web.reports.acts import acts_of_session
from truepose.web.results.origins import origin_of
from truepose.web.results.traces import session_conditions
from truepose.web.visiting.moments import moment
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.traceability.conditions import Event, ReportConditions


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


async def conditions_of_campaign(here: Context, campaign_id: int, words: Catalogue) -> "ReportConditions":
    """Return the conditions of the sessions that a campaign is made of, else what came with its upload."""
    from truepose.reports.traceability.conditions import ReportConditions

    campaign = await here.campaigns.get(campaign_id)
    if campaign.session_ids:
        return await conditions_of_sessions(here, campaign.session_ids, words)
    return ReportConditions(simulated=campaign.simulated, notes=campaign.summary.notes)


def _closing_of(numbers: Sequence[int], closings: Sequence[Closing | None]) -> Sentence:
    """Return what each session was closed as; a single one needs no number."""
    if len(numbers) == 1:
        return closing_sentence(closings[0])
    each = zip(numbers, map(closing_sentence, closings), strict=True)
    return said(
        "closings", sentences=tuple(said("closing.of", number=number, closing=one) for number, one in each)
    )


def closing_sentence(closing: Closing | None) -> Sentence:
    """Return what a session was closed as, by whom, and what was passed over."""
    if closing is None:
        return said("closing.open")
    person, day = closing.person, moment(closing.closed_at)
    if closing.closed_as == "not calibrated":
        return said("closing.not_calibrated", person=person, day=day, reason=closing.reason)
    if not closing.overridden:
        return said("closing.calibrated", person=person, day=day)
    faults = tuple(one.fault for one in closing.overridden)
    return said("closing.overridden", person=person, day=day, faults=faults, reason=closing.reason)


def _closed(closings: Sequence[Closing | None]) -> "Iterator[Event]":
    from truepose.reports.traceability.conditions import Event

    for one in closings:
        if one is not None:
            yield Event(moment(one.closed_at), one.person, closing_sentence(one))
