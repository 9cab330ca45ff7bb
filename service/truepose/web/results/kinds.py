"""What every kind of result has in common: which sessions it is of, its page, and the form that plans one."""

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from markupsafe import Markup

from truepose.domain.results.validation import DecisionRule
from truepose.storage.records import SessionRecord
from truepose.web.context import Context
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.front.page import Front


@dataclass(frozen=True, slots=True)
class Origin:
    """A session, and what its plan was asked for."""

    record: SessionRecord
    asked: Mapping[str, Any]  # empty where its stops were given

    @property
    def method(self) -> str:
        """How its stops were planned, as requests name it; empty where no test was asked for."""
        return str(self.asked.get("method") or self.record.test or "")


@dataclass(frozen=True, slots=True)
class Choice:
    """What whoever reads a result may choose."""

    model_id: int | None = None  # which judges; None: the one that was to be proved, else the newest
    limit_mm: float | None = None
    rule: DecisionRule = "guard band"


FirstPage: TypeAlias = "Callable[[Context, Origin, Choice, Catalogue], Awaitable[Front]]"
Content: TypeAlias = Callable[[Context, Origin, Choice, Catalogue], Awaitable[Markup]]


@dataclass(frozen=True, slots=True)
class Entry:
    """A number, a choice or a model that a form asks for."""

    name: str  # in the body of the request; dots lead into it, and several of one name are a list
    label: str  # key of the catalogue
    kind: Literal["number", "choice", "model", "model or none"] = "number"
    value: float | str | None = ""  # "": it may be left out; None: whoever plans must say it
    least: float | None = None
    most: float | None = None
    choices: tuple[tuple[str, str], ...] = ()  # value, key of the catalogue


@dataclass(frozen=True, slots=True)
class Form:
    """How such a session is planned from a page."""

    meaning: str  # key of the catalogue
    entries: tuple[Entry, ...]
    body: Mapping[str, Any]  # what the request holds beside the entries
    path: str = "/api/v1/sessions"


@dataclass(frozen=True, slots=True)
class ResultKind:
    """A kind of result."""

    name: str  # in the address of its form
    title: str  # key of the catalogue
    is_of: Callable[[Origin], bool]
    content: Content
    judges: bool = False  # a model that the reader may choose
    limited: bool = False  # held against a limit that the reader may set
    form: Callable[[Context], Form] | None = field(default=None)  # None: planned elsewhere
    first_page: "FirstPage | None" = None  # of its report; None: its content says it all
