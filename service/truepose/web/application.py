"""The web application of a cell: all of its routes."""

from typing import Final

from starlette.routing import BaseRoute

from truepose.web.api import (
    authority,
    campaigns,
    cells,
    chain,
    closings,
    corrections,
    deployments,
    diagnoses,
    drafts,
    events,
    expected_accuracy,
    health,
    identifications,
    jobs,
    models,
    people,
    readings,
    robots,
    series,
    sign_ins,
    simulated_cell,
    spaces,
    watch_links,
)
from truepose.web.api import repeat_session as repeat_session_api
from truepose.web.api.sessions import commands, following, sessions
from truepose.web.api.sessions import spaces as session_spaces
from truepose.web.asgi import Application, OpenContext, application_of
from truepose.web.middleware.hosts import AllowedHosts, Proxies
from truepose.web.pages import (
    campaign,
    cell,
    correction,
    diagnosis,
    identification,
    plan,
    reference,
    repeat_session,
    reports,
    robot,
    work,
)
from truepose.web.pages import people as people_pages
from truepose.web.pages import residuals as residual_pages
from truepose.web.pages import sessions as session_pages
from truepose.web.tablet import routes as tablet

_RESOURCES: Final = (
    health.router,
    cells.router,
    cells.devices_router,
    robots.router,
    sessions.router,
    commands.router,
    following.router,
    repeat_session_api.router,
    closings.router,
    session_spaces.router,
    expected_accuracy.router,
    simulated_cell.hands_router,
    simulated_cell.router,
    readings.router,
    series.router,
    jobs.router,
    identifications.router,
    identifications.validations_router,
    diagnoses.router,
    models.router,
    corrections.router,
    campaigns.router,
    spaces.router,
    spaces.residuals_router,
    sign_ins.router,
    people.router,
    authority.router,
    watch_links.router,
    drafts.router,
    events.router,
    chain.router,
    deployments.router,
)
_PAGES: Final = (
    diagnosis,
    plan,
    session_pages,
    correction,
    reports,
    campaign,
    cell,
    work,
    identification,
    residual_pages,
    repeat_session,
    robot,
    reference,
    people_pages,
)


def create_application(
    version: str,
    open_context: OpenContext,
    hosts: AllowedHosts | None = None,
    proxies: Proxies | None = None,
) -> Application:
    """Return the application of a cell, as `application_of` does that of any routes."""
    return application_of(_routes(), version, open_context, hosts, proxies)


def _routes() -> list[BaseRoute]:
    """Return all routes; they keep nothing of an application, so that every one of a process has the same."""
    of_pages = [page.router for page in _PAGES]
    routers = (*_RESOURCES, *of_pages, watch_links.pages, tablet.router)
    return [route for router in routers for route in router.routes]
