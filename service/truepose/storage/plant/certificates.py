"""Certificates as the records of cells state them; they follow the serial number, whichever cell says it."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import date
from typing import Any, Final

from sqlalchemy import Connection, select

from truepose.domain.cell import Paper, Standing
from truepose.storage.plant.records import DAY, Branch, CollectedLink, Document, document_in
from truepose.storage.plant.tables import plant_branches, plant_cells, plant_certificates
from truepose.storage.queries import Repository
from truepose.storage.record_insertion import add_row
from truepose.storage.rows import to_row


@dataclass(frozen=True, slots=True)
class CertificateRecord:
    """A certificate, by the cell that stated it first, and when."""

    paper: Paper
    cell: str
    stated_on: str

    def standing(self, on: date) -> Standing:
        """Return how it stands on a day; what states a day that is none is undated."""
        try:
            return self.paper.standing(on)
        except ValueError:
            return "undated"


class PlantCertificates(Repository):
    """All queries about certificates."""

    async def of_instrument(self, serial_number: str) -> list[CertificateRecord]:
        """Return every certificate that was stated for a serial number, the one that holds longest first."""
        query = _stated().where(plant_certificates.c.serial_number == serial_number)
        return _longest_first(await self._all(query))

    async def that_count(self) -> list[CertificateRecord]:
        """Return of each serial number the certificate that holds longest, the first to end first.

        What has no number is told apart by cell and name.
        """
        counting: dict[tuple[str, ...], CertificateRecord] = {}
        for found in _longest_first(await self._all(_stated())):
            serial = found.paper.serial_number
            # Certificates follow the serial number, whichever cell has the instrument by now (decision 0020).
            # What has no number can be told apart only where it stands.
            counting.setdefault((serial,) if serial else (found.cell, found.paper.of, ""), found)
        return sorted(counting.values(), key=lambda found: found.paper.expires)

    async def _all(self, query: Any) -> list[CertificateRecord]:
        return [_stated_paper(*row) for row in await self._rows(query)]


def _stated() -> Any:
    known = plant_certificates.c
    columns = (known.what, known.serial_number, known.certificate, known.expires)
    return (
        select(*columns, plant_cells.c.name, known.stated_on)
        .join(plant_branches, plant_branches.c.id == known.branch_id)
        .join(plant_cells, plant_cells.c.id == plant_branches.c.cell_id)
        .order_by(known.id)
    )


def _stated_paper(
    what: str, serial: str, certificate: str, expires: str, cell: str, stated_on: str
) -> CertificateRecord:
    return CertificateRecord(Paper(what, serial, certificate, expires), cell, stated_on)


def _longest_first(found: Iterable[CertificateRecord]) -> list[CertificateRecord]:
    return sorted(found, key=lambda one: (one.paper.expires, one.stated_on), reverse=True)


def stated_certificates(record: str, row: Document) -> list[Paper]:
    """Return the certificates that a record states, each with its text; none where it states none."""
    read = STATING.get(record)
    return [] if read is None else [paper for paper in read(row) if paper.certificate.strip()]


def add_certificates(
    connection: Connection, branch: Branch, link: CollectedLink, papers: Iterable[Paper]
) -> None:
    """Add certificates that were not stated before, inside the caller's transaction."""
    day = str((link.row or {}).get("recorded_at", ""))[:DAY]
    for paper in papers:
        # Every session states all certificates of its cell: only what is new is a row.
        if not _is_known(connection, branch, paper):
            add_row(
                connection,
                plant_certificates,
                branch_id=branch.id,
                link=link.link,
                what=paper.of,
                **to_row(paper, plant_certificates),
                stated_on=day,
            )


def _is_known(connection: Connection, branch: Branch, paper: Paper) -> bool:
    known = plant_certificates.c
    same = (known.certificate == paper.certificate) & (known.expires == paper.expires)
    query = select(known.id).where(known.serial_number == paper.serial_number, same)
    if not paper.serial_number:
        query = query.where(known.branch_id == branch.id, known.what == paper.of)
    return connection.scalar(query.limit(1)) is not None


def _of_session(row: Document) -> Iterator[Paper]:
    cell = document_in(row, "setup").get("cell", {})
    bar = cell.get("ballbar") or {}
    stated = (*cell.get("devices", ()), bar.get("instrument"), bar.get("calibrator"))
    for one in (*stated, cell.get("tool"), cell.get("world")):
        if one:
            values = ("name", "serial_number", "certificate", "certificate_expires")
            yield Paper(*(str(one.get(value) or "") for value in values))


def _of_closing(row: Document) -> Iterator[Paper]:
    for judged in document_in(row, "document"):
        yield Paper(**judged["paper"])


def _of_campaign(row: Document) -> Iterator[Paper]:
    """Yield what was said of the instrument where readings were brought; one without a number is no one's."""
    said = document_in(row, "summary")
    if said.get("instrument_serial_number"):
        values = ("instrument", "instrument_serial_number", "certificate")
        yield Paper(*(str(said.get(value) or "") for value in values))


STATING: Final[Mapping[str, Callable[[Document], Iterator[Paper]]]] = {
    "sessions": _of_session,
    "closings": _of_closing,
    "campaigns": _of_campaign,
}
