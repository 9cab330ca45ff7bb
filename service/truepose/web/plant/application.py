"""The web application of a plant: the same middleware and people as a cell's, and routes of its own."""

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager

from starlette.routing import BaseRoute

from truepose.web.api import people, sign_ins
from truepose.web.asgi import Application, application_of
from truepose.web.middleware.hosts import AllowedHosts, Proxies
from truepose.web.pages import reference
from truepose.web.pages.people import router as pages_of_people
from truepose.web.pages.rendering import prepare
from truepose.web.plant import cells, changes, deployments, fleet, inventory, overview, robot_histories
from truepose.web.plant.context import PlantContext

_TEMPLATES = ("frame.html", "people/chip.html", "people/dialogue.html", "plant/")
_RESOURCES = (cells, deployments, changes, inventory, sign_ins, people)


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
        cells.health_router,
        *(resource.router for resource in _RESOURCES),
        overview.router,
        fleet.router,
        robot_histories.router,
        pages_of_people,
        reference.router,  # with the error pages to which problem documents lead
    )
    return [route for router in routers for route in router.routes]
