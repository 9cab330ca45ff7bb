"""The web application of a plant: the same door, gate and people as a cell's, and routes of its own."""

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager

from starlette.routing import BaseRoute

from truepose.web.application import Application, create_application
from truepose.web.door.hosts import AllowedHosts
from truepose.web.door.proxies import Proxies
from truepose.web.pages import router as pages
from truepose.web.people import acts, people, sign_ins
from truepose.web.people.pages import router as pages_of_people
from truepose.web.plant import cells, fleets, glance, hand_downs, health, seen
from truepose.web.plant import pages as pages_of_plant
from truepose.web.plant.context import PlantContext
from truepose.web.visiting.rendering import prepare

# What pages of people are made of; a plant has no cell to show.
_OF_PAGES = frozenset({"static_file", "report_style", "colours", "package_file", "api_page"})
_TEMPLATES = ("frame.html", "people/chip.html", "people/dialogue.html", "plant/")
_RESOURCES = (cells, hand_downs, seen, sign_ins, people, acts)


def create_plant_application(
    version: str,
    open_context: Callable[[], AbstractAsyncContextManager[PlantContext]],
    hosts: AllowedHosts | None = None,
    proxies: Proxies | None = None,
) -> Application:
    """Return the application of a plant, as `create_application` does a cell's; its pages are ready."""
    prepare(*_TEMPLATES)
    return create_application(version, open_context, hosts, proxies, _routes())


def _routes() -> list[BaseRoute]:
    routers = (
        health.router,
        *(resource.router for resource in _RESOURCES),
        glance.router,
        fleets.router,
        pages_of_plant.router,
        pages_of_people,
    )
    shared = [route for route in pages.routes if getattr(route, "name", "") in _OF_PAGES]
    return [*(route for router in routers for route in router.routes), *shared]
