"""Series: readings that a program of one's own delivers as they come."""

from fastapi import Response, status

from truepose.analysis.delivered import draft_of_series
from truepose.domain.measurement.series import Delivery
from truepose.web.context import Here
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import Id
from truepose.web.resources import resource
from truepose.web.schemas.calibration.drafts import DraftReply, draft_reply
from truepose.web.schemas.measurement.series import (
    DeliveredReadingReply,
    DeliveredReply,
    DeliveryRequest,
    SeriesReply,
    SeriesRequest,
    series_reply,
)

router = resource("/series", tags=["series"])


@router.post("", status_code=status.HTTP_201_CREATED, responses=problems(400, 413, 415, 422, 503))
async def start_series(here: Here, response: Response, wanted: SeriesRequest) -> SeriesReply:
    """Begin a series: say what its columns are, as the header of a table would."""
    number = await here.series.begin(wanted.series())
    response.headers["Location"] = f"/api/v1/series/{number}"
    return series_reply(await here.series.get(number))


@router.get("", responses=listing(422, 503))
async def list_series(here: Here, paging: Paged) -> list[SeriesReply]:
    """List series, oldest first."""
    return paging.shown(await here.series.page(paging.page), series_reply)


@router.get("/{id}", responses=problems(404, 422, 503))
async def get_series(here: Here, id: Id) -> SeriesReply:
    """Show a series, and the number of the reading that it goes on at."""
    return series_reply(await here.series.get(id))


@router.post(
    "/{id}/readings",
    status_code=status.HTTP_201_CREATED,
    responses=problems(400, 404, 409, 413, 415, 422, 503),
)
async def add_readings(here: Here, id: Id, wanted: DeliveryRequest) -> DeliveredReply:
    """Deliver readings; the answer comes when they are on disk.

    `first` numbers them: a delivery whose answer was lost is sent again as it was, and kept once. One that
    leaves a gap, or says something else of a number that is taken, is refused (409).
    """
    delivery = Delivery(wanted.first, tuple(map(tuple, wanted.readings)))
    await here.series.deliver(id, delivery)
    return DeliveredReply(next_number=delivery.next_number)


@router.get("/{id}/readings", responses=listing(404, 422, 503))
async def list_readings_of_series(here: Here, id: Id, paging: Paged) -> list[DeliveredReadingReply]:
    """List the readings of a series in their order."""
    record = await here.series.get(id)
    readings = await here.series.readings(id, paging.page)
    last = readings[-1].number if readings else paging.page.after
    paging.say(record.readings, last if last < record.readings and readings else None)
    return [DeliveredReadingReply.of(one, values=list(one.values)) for one in readings]


@router.post(
    "/{id}/draft", status_code=status.HTTP_201_CREATED, responses=problems(404, 409, 413, 415, 422, 503)
)
async def make_draft_of_series(here: Here, response: Response, id: Id) -> DraftReply:
    """Bring what a series holds so far, as if its table had been dropped at `/bring`."""
    draft = await draft_of_series(here.series, here.draft_desk, id)
    response.headers["Location"] = f"/api/v1/drafts/{draft.id}"
    return draft_reply(draft)
