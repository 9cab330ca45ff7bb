"""Certificates of instruments and artefacts: which hold, and what a session is closed as."""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date, timedelta
from typing import Final, Literal, TypeAlias

from truepose.domain.sentences import Sentence, Text, said

Standing: TypeAlias = Literal["holds", "ends soon", "expired", "undated", "missing"]
ClosedAs: TypeAlias = Literal["calibrated", "not calibrated"]
WARNED: Final = timedelta(days=30)  # before the end of a certificate
_FAULTS: Final = {
    "expired": "certificate.expired",
    "undated": "certificate.undated",
    "missing": "certificate.missing",
}


@dataclass(frozen=True, slots=True)
class Paper:
    """What an instrument or artefact has to show."""

    of: str  # "laser tracker", or the name of an artefact
    serial_number: str = ""
    certificate: str = ""  # number, date, laboratory
    expires: str = ""  # ISO date; empty where nobody said it

    @property
    def called(self) -> Sentence:
        """What it is of, with its serial number where that is known."""
        if not self.serial_number:
            return said("certificate.named", what=self.of)
        return said("certificate.numbered", what=self.of, serial=self.serial_number)

    def standing(self, on: date) -> Standing:
        """Return whether the certificate holds on a day, its last one included."""
        if not self.certificate.strip():
            return "missing"
        if not self.expires:
            return "undated"
        last = date.fromisoformat(self.expires)
        if last < on:
            return "expired"
        return "ends soon" if last - on <= WARNED else "holds"


@dataclass(frozen=True, slots=True)
class JudgedPaper:
    """A certificate as it stood on the day that it was judged for."""

    paper: Paper
    standing: Standing

    @property
    def proves(self) -> bool:
        """Whether it held on that day."""
        return self.standing in {"holds", "ends soon"}

    @property
    def fault(self) -> Text:
        """What is wrong with it, "" where it held."""
        if self.proves:
            return ""
        paper = self.paper
        return said(
            _FAULTS[self.standing], what=paper.called, certificate=paper.certificate, day=paper.expires
        )


@dataclass(frozen=True, slots=True)
class Closing:
    """What a person closed a session as, on which certificates, and why where one did not hold."""

    session_id: int
    closed_as: ClosedAs
    person: str
    reason: str
    certificates: tuple[JudgedPaper, ...]
    closed_at: str = ""  # when it was stored

    @property
    def overridden(self) -> tuple[JudgedPaper, ...]:
        """Return the certificates that did not hold and were passed over."""
        if self.closed_as != "calibrated":
            return ()
        return tuple(one for one in self.certificates if not one.proves)


def judged_papers(papers: Iterable[Paper], on: date) -> tuple[JudgedPaper, ...]:
    """Return certificates as they stand on a day."""
    return tuple(JudgedPaper(paper, paper.standing(on)) for paper in papers)
