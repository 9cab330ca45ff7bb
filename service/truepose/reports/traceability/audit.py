"""By which records a printed figure is found again."""

from collections.abc import Iterator
from dataclasses import dataclass

from truepose.words.catalogue import IN_ENGLISH, Catalogue


@dataclass(frozen=True, slots=True)
class Audit:
    """Records behind a page, each with a SHA-256 that tells whether it is still the same."""

    session_id: int
    session_sha256: str  # of the newest link of its chain
    document: str  # address of the same figures as JSON
    document_sha256: str  # of what is sent from there
    model_id: int | None = None  # None: no model is judged
    model_sha256: str = ""  # of its file


def audit_rows(audit: Audit, words: Catalogue = IN_ENGLISH) -> Iterator[tuple[str, str, str]]:
    """Yield what each record is called, where it is, and its hash."""
    yield (
        words.say("audit.session", number=audit.session_id),
        f"/api/v1/sessions/{audit.session_id}",
        audit.session_sha256,
    )
    if audit.model_id is not None:
        file = f"/api/v1/models/{audit.model_id}/file"
        yield words.say("audit.model", number=audit.model_id), file, audit.model_sha256
    yield words.say("audit.document"), audit.document, audit.document_sha256
