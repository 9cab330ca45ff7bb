"""The web application of a plant: the same door, gate and people as a cell's, and routes of its own."""

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager

from starlette.routing import BaseRoute

from truepose.web.door.hosts import AllowedHosts
from truepose.web.door.proxies import Proxies
from truepose.web.people import acts, people, sign_ins
from truepose.web.people.pages import router as pages_of_people
from truepose.web.places import error_pages
from truepose.web.plant import cells, changes, fleets, hand_downs, health, seen
from truepose.web.plant.context import PlantContext
from truepose.web.plant.pages import cell, glance, lives
from truepose.web.served import Application, application_of
from truepose.web.visiting import everywhere
from truepose.web.visiting.rendering import prepare

_TEMPLATES = ("frame.html", "people/chip.html", "people/dialogue.html", "plant/")
_RESOURCES = (cells, hand_downs, changes, seen, sign_ins, people, acts)


def create_plant_application(
    version: str,
    open_context: Callable[[], AbstractAsyncContextManager[PlantContext]],
    hosts: AllowedHosts | None = None,
    proxies: Proxies | None = None,
) -> Application:
    """Return the application of a plant, as `application_of` does that of any routes; its pages are ready."""
    prepare(*_TEMPLATES)
    return application_of(_routes(), version, open_context, hosts, proxies)


def _routes() -> list[BaseRoute]:
    routers = (
        health.router,
        *(resource.router for resource in _RESOURCES),
        glance.router,
        fleets.router,
        lives.router,
        cell.router,
        pages_of_people,
        everywhere.router,
        error_pages.router,  # to which problem documents lead
    )
    return [route for router in routers for route in router.routes]
