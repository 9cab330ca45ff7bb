"""A campaign: what it holds, and what was made of it."""

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.storage.work.items import WorkKind
from truepose.web.records.trail import missing, record_at, trail_of
from truepose.web.visiting.visits import Visited

router = APIRouter(prefix="/campaigns", include_in_schema=False)
_COUNTS = {
    "calibration_points": "campaign.calibration_points",
    "validation_points": "campaign.validation_points",
    "calibration_legs": "campaign.calibration_legs",
    "validation_legs": "campaign.validation_legs",
    "calibration_contacts": "campaign.calibration_contacts",
    "validation_contacts": "campaign.validation_contacts",
    "reference_readings": "campaign.reference_readings",
}


@router.get("/{id}", response_class=HTMLResponse)
async def campaign_page(visit: Visited, id: str) -> HTMLResponse:
    """Show a campaign."""
    record = await record_at(id, visit.here.campaigns.get)
    if record is None:
        return missing(visit)
    counts = [(key, getattr(record.summary, name)) for name, key in _COUNTS.items()]
    trail = await trail_of(visit, WorkKind.CAMPAIGN, record.id)
    return visit.page("campaign.html", record=record, counts=[one for one in counts if one[1]], trail=trail)
