"""What can go wrong, by code: for whoever has one in front of them, or is told one on the telephone."""

from http import HTTPStatus
from itertools import groupby
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.web.visiting.visits import Visited
from truepose.words.error_codes import CODES, explained

router = APIRouter(prefix="/errors", include_in_schema=False)
_GROUP: Final = len("TP-")  # where in a code the digit of its group stands


@router.get("", response_class=HTMLResponse)
async def errors_page(visit: Visited) -> HTMLResponse:
    """List every code with what happened."""
    groups = [
        (visit.words.say(f"page.errors.group.{digit}"), [explained(code, visit.words) for code in codes])
        for digit, codes in groupby(CODES, lambda code: code[_GROUP])
    ]
    return visit.page("errors/errors.html", groups=groups)


@router.get("/{code}", response_class=HTMLResponse)
async def error_page(visit: Visited, code: str) -> HTMLResponse:
    """Say what a code means, for the data too, and what to do now."""
    wanted = code.upper()
    if wanted not in CODES:
        return visit.page("errors/no_error.html", HTTPStatus.NOT_FOUND, code=code)
    return visit.page("errors/error.html", told=explained(wanted, visit.words), sentence="")
