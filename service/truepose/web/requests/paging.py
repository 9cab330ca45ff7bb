"""Pages of lists: which part is asked for, how many there are in all, and where the next part is."""

from collections.abc import Callable, Sequence
from typing import Annotated, Any, Final, TypeVar

from fastapi import Depends, Query, Request, Response

from truepose.storage.parts import Part
from truepose.storage.records import Page
from truepose.web.problems import problems
from truepose.web.schemas.base import NUMBER_LIMIT

R = TypeVar("R")
T = TypeVar("T")
MOST: Final = 500  # of a page, however many are asked for
_TOTAL: Final = "Total-Count"
_HEADERS: Final[dict[str, Any]] = {
    _TOTAL: {
        "description": "How many records the whole list has.",
        "schema": {"type": "integer", "minimum": 0},
        "example": 1204,
    },
    "Link": {
        "description": 'Where the next page is, as `<...>; rel="next"` (RFC 8288); absent on the last one.',
        "schema": {"type": "string"},
        "example": '</api/v1/sessions?after=100&limit=100>; rel="next"',
    },
}
After = Annotated[int, Query(ge=0, le=NUMBER_LIMIT, description="List records above this number.")]
LeftOut = Annotated[
    int, Query(ge=0, le=NUMBER_LIMIT, description="How many are left out from the beginning of the list.")
]
Limit = Annotated[
    int, Query(ge=1, le=1000, description=f"At most so many records; a page never has more than {MOST}.")
]


class Paging:
    """Which page of a list a request asks for, and what its answer says of the whole list."""

    def __init__(
        self,
        request: Request,
        response: Response,
        after: After = 0,
        limit: Limit = 100,
    ) -> None:
        self.page = Page(after, min(limit, MOST))
        self._request = request
        self._response = response

    def shown(self, part: Part[R], reply: Callable[[R], T]) -> list[T]:
        """Return a part as it travels; headers of the answer say how many there are and what comes next."""
        self.say(part.total, part.next_after)
        return [reply(record) for record in part]

    def say(self, total: int, next_after: int | None) -> None:
        """Let the answer say how many records there are, and behind which number the next page begins."""
        self._response.headers[_TOTAL] = str(total)
        if next_after is not None:
            url = self._request.url.include_query_params(after=next_after, limit=self.page.limit)
            self._response.headers["Link"] = f'<{url.path}?{url.query}>; rel="next"'


class Counting(Paging):
    """Paging of what has no numbers of its own: counted from the beginning, as many as a page may have."""

    def __init__(
        self,
        request: Request,
        response: Response,
        after: LeftOut = 0,
        limit: Limit = MOST,
    ) -> None:
        super().__init__(request, response, after, limit)

    def of(self, records: Sequence[R], reply: Callable[[R], T]) -> list[T]:
        """Return the part of a list that is asked for as it travels; headers tell of the whole."""
        end = self.page.after + self.page.limit
        self.say(len(records), end if end < len(records) else None)
        return [reply(record) for record in records[self.page.after : end]]


Paged = Annotated[Paging, Depends()]
Counted = Annotated[Counting, Depends()]


def listing(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return what the route of a list has under `responses`: its headers, and its problems."""
    return {200: {"headers": _HEADERS}, **problems(*statuses)}
