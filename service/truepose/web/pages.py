"""All pages of a cell for people."""

from fastapi import APIRouter

from truepose.web.again import page as again_page
from truepose.web.calibration import bring_pages, correction_pages
from truepose.web.leaving import pages as hand_down_pages
from truepose.web.people import watching
from truepose.web.places import cell_page, error_pages, fault_pages, robot_pages, work_page
from truepose.web.records import campaign_page, diagnosis_pages, job_page, plan_page, result_pages
from truepose.web.reports import checklists, closing_pages
from truepose.web.reports import pages as report_pages
from truepose.web.results import pages as session_pages
from truepose.web.visiting import everywhere

router = APIRouter(include_in_schema=False)
for room in (
    *(diagnosis_pages, plan_page, session_pages, correction_pages, report_pages, closing_pages, checklists),
    *(bring_pages, fault_pages, cell_page, work_page, job_page, campaign_page, result_pages),
    *(again_page, robot_pages, error_pages, hand_down_pages, everywhere),
):
    router.routes += room.router.routes  # `web/resources.py` says why
router.routes += watching.pages.routes
