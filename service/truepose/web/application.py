"""The web application of a cell: all of its routes."""

from typing import Final

from starlette.routing import BaseRoute

from truepose.web import events, jobs, pages
from truepose.web.again import routes as again
from truepose.web.calibration import (
    campaigns,
    corrections,
    diagnoses,
    drafts,
    identifications,
    models,
    robots,
    spaces,
    validations,
)
from truepose.web.door.hosts import AllowedHosts
from truepose.web.door.proxies import Proxies
from truepose.web.healthiness import routes as health
from truepose.web.leaving import chain, hand_downs
from truepose.web.measurement import (
    cells,
    closings,
    contact_sessions,
    devices,
    guides,
    promises,
    readings,
    series,
    session_spaces,
    sessions,
)
from truepose.web.measurement.ballbar import live as ballbar_live
from truepose.web.measurement.ballbar import sessions as ballbar_sessions
from truepose.web.measurement.simulated import faults as simulated_faults
from truepose.web.measurement.simulated import hands as simulated_hands
from truepose.web.observation import routes as metrics
from truepose.web.people import acts, authority, people, sign_ins, watching
from truepose.web.people.pages import router as pages_of_people
from truepose.web.served import Application, OpenContext, application_of
from truepose.web.tablet import routes as tablet

_RESOURCES: Final = (
    cells,
    devices,
    robots,
    sessions,
    again,
    closings,
    session_spaces,
    promises,
    ballbar_sessions,
    ballbar_live,
    contact_sessions,
    guides,
    simulated_hands,
    simulated_faults,
    readings,
    series,
    jobs,
    identifications,
    validations,
    diagnoses,
    models,
    corrections,
    campaigns,
    spaces,
    sign_ins,
    people,
    acts,
    authority,
    watching,
    drafts,
    events,
    chain,
    hand_downs,
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
    of_api = [resource.router for resource in _RESOURCES]
    routers = (health.router, metrics.router, *of_api, pages.router, pages_of_people, tablet.router)
    return [route for router in routers for route in router.routes]
