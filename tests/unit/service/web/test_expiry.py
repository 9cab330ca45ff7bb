from dataclasses import replace
from datetime import date

from tests.helpers.domain.tracker_sessions import make_setup
from truepose.domain.cell import DeviceEntry
from truepose.messages.catalogue import english
from truepose.web.pages.conditions import expiry_warnings

CELL = replace(make_setup().cell, tool=None, world=None, ballbar=None)


def warned(expires, today=date(2026, 11, 23)):
    cell = replace(CELL, devices=(DeviceEntry("laser", "leica_emscon", {}, "390007", "report 7", expires),))
    return [english(one) for one in expiry_warnings(cell, today)]


def test_it_is_said_thirty_days_before_and_after_the_end():
    assert warned("2026-12-23") == [
        "The certificate of the laser, serial number 390007 expires on 2026-12-23: 30 days are left."
    ]
    assert "expired on 2026-11-22" in warned("2026-11-22")[0]


def test_nothing_is_said_before_or_where_no_day_is_stated():
    assert warned("2026-12-24") == []
    assert warned("") == []
