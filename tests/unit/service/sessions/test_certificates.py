"""Certificates follow serial numbers; what is claimed for one instrument is claimed for no other."""

from dataclasses import replace

from tests.helpers.domain.tracker_sessions import make_setup
from truepose.domain.cell import Artefact, BallbarKit, DeviceEntry
from truepose.domain.robot import Nest
from truepose.domain.session import IdentityTaken
from truepose.sessions.closing import papers_of_cell, papers_of_session

TRACKER = DeviceEntry("laser", "leica_emscon", {}, "390007", "report 7", "2027-03-31")
USED = {"tracker": "laser", "robot": "robot", "ballbar": "bar"}
CELL = replace(make_setup().cell, devices=(TRACKER,), tool=None, world=None, nests=(Nest(None),))


def taken(device, serial):
    return IdentityTaken(device, "first", serial)


def papers(cell, *identities, by_bar=False):
    return list(papers_of_session(cell, identities, USED, by_bar=by_bar))


def test_an_instrument_shows_the_certificate_of_its_serial_number():
    (paper,) = papers(CELL, taken("tracker", "390007"), taken("tracker", "390007"))

    assert (paper.of, paper.serial_number) == ("laser tracker", "390007")
    assert (paper.certificate, paper.expires) == ("report 7", "2027-03-31")


def test_another_instrument_shows_none():
    _, other = papers(CELL, taken("tracker", "390007"), taken("tracker", "391234"))

    assert (other.serial_number, other.certificate) == ("391234", "")


def test_without_a_number_the_first_instrument_may_claim_it_and_no_further_one():
    unnumbered = replace(CELL, devices=(replace(TRACKER, serial_number=""),))

    first, second = papers(unnumbered, taken("tracker", "1"), taken("tracker", "2"))

    assert (first.certificate, second.certificate) == ("report 7", "")


def test_a_silent_instrument_claims_nothing_that_names_a_number():
    (paper,) = papers(CELL, taken("tracker", ""))

    assert paper.certificate == ""


def test_the_robot_measures_nothing_and_shows_nothing():
    assert papers(CELL, taken("robot", "120-1")) == []


def test_artefacts_count_where_the_readings_rest_on_them():
    plate, tool = Artefact("plate", "", "report 8"), Artefact("tool", "", "report 9")
    bar = BallbarKit(instrument=Artefact("QC20", "77", "report 10"), calibrator=Artefact("calibrator"))
    full = replace(CELL, world=plate, tool=tool, ballbar=bar)
    known = replace(full, nests=(Nest((1.0, 2.0, 3.0)),))

    assert [paper.of for paper in papers(full)] == ["plate"]
    assert [paper.of for paper in papers(known)] == ["tool", "plate"]
    by_bar = papers(known, taken("ballbar", "77"), by_bar=True)
    assert [(paper.of, paper.certificate) for paper in by_bar] == [
        ("ballbar", "report 10"), ("calibrator", ""), ("tool", "report 9"),
    ]  # fmt: skip


def test_of_a_cell_every_certificate_that_is_stated_is_watched():
    cell = replace(CELL, world=Artefact("plate", "", "report 8"), tool=Artefact("tool"))

    assert [(one.of, one.certificate) for one in papers_of_cell(cell)] == [
        ("laser", "report 7"), ("plate", "report 8"),
    ]  # fmt: skip
