"""Tables of closed loops: what they may leave out, and what is refused."""

import dataclasses
import math

import numpy as np
import pytest

from tests.helpers.domain.builders import make_contact_campaign, make_contacts
from tests.unit.service.exchange.test_campaign_round_trip import assert_equal, written_and_read
from truepose.domain.campaign import NO_AXIS
from truepose.domain.contacts import Target, TargetKind
from truepose.exchange.campaigns.folder import campaign_files, campaign_from
from truepose.exchange.errors import InputFileError
from truepose.exchange.tables.contacts import read_contact_table, read_distance_table, read_target_table
from truepose.exchange.tables.files import held_out_readings

HEADER = "config,q1_deg,target,nest,reading_mm,u_mm"
SPHERES = (Target(1, TargetKind.SPHERE), Target(2, TargetKind.SPHERE), Target(4, TargetKind.PLANE))
BALL = (Target(1, TargetKind.BALL),)


def rows(*lines):
    return "\n".join(lines).encode()


def contacts(*lines, header=HEADER, targets=SPHERES):
    return read_contact_table("contacts.csv", rows(header, *lines), 1, range(1, 4), targets)[0]


def distances(*lines, targets=SPHERES):
    return read_distance_table("d.csv", rows("target_a,target_b,distance_mm,u_mm", *lines), targets)


def test_a_closed_loop_reads_back_equal():
    campaign = make_contact_campaign()

    again = written_and_read(campaign)

    assert_equal(campaign, again)


def test_readings_along_no_axis_are_written_without_the_column():
    plain = make_contacts(axis=None, target=np.ones(3, np.int64))

    text = campaign_files(make_contact_campaign(contacts=plain))["contacts.csv"]

    assert "axis" not in text.splitlines()[0]


def test_targets_are_read_first_wherever_they_are_named():
    files = campaign_files(make_contact_campaign())
    files["campaign.json"] = (
        files["campaign.json"]
        .replace('"targets": "targets.csv",', "")
        .replace('"contacts": "contacts.csv"', '"contacts": "contacts.csv", "targets": "targets.csv"')
    )

    campaign = campaign_from(lambda name: files[name].encode())

    assert len(campaign.targets) == 3


def test_of_a_target_number_and_kind_are_enough():
    (target,), _ = read_target_table("targets.csv", b"target,kind\n3,wire\n")

    assert target == Target(3, TargetKind.WIRE)
    assert target.zero_mm is None


def test_an_empty_cell_of_a_target_is_unknown():
    text = rows("target,kind,zero_mm,u_zero_mm,x_mm,y_mm,z_mm", "1,sphere,,,,,", "2,sphere,25.4,0.001,1,2,3")

    (first, second), _ = read_target_table("targets.csv", text)

    assert first == Target(1, TargetKind.SPHERE)
    assert second == Target(2, TargetKind.SPHERE, 25.4, 0.001, place_mm=(1.0, 2.0, 3.0))


def test_a_row_without_an_axis_has_none():
    read = contacts("1,10,1,1,0,0.002", "2,20,4,1,-0.5,0.002")

    assert read.axis is None
    assert read.axes.tolist() == [NO_AXIS, NO_AXIS]
    assert read.reading_mm.tolist() == [0.0, -0.5]


@pytest.mark.parametrize(
    ("read", "words"),
    [
        (lambda: contacts("1,10,3,1,0,0.002"), "one of the targets: 1, 2, 4"),
        (lambda: contacts("1,10,1,4,0,0.002"), "one of the tool nests"),
        (lambda: contacts("1,10,1,1,0,0.002", targets=()), "files.targets"),
        (lambda: contacts("1,10,1,1,0,0.002", targets=BALL), "along an axis of its sensor"),
        (lambda: contacts("1,10,1,1,0,0.002,x", header=HEADER + ",axis"), "only a reading of ball or face"),
        (lambda: contacts("1,10,1,1,0,0.002,w", header=HEADER + ",axis", targets=BALL), "x or y or z"),
        (lambda: contacts("1,10,1,1,0,0"), "greater than 0"),
        (lambda: read_target_table("targets.csv", b"target,kind\n1,cube\n"), "sphere or wire"),
        (lambda: read_target_table("targets.csv", b"target,kind\n1,wire\n1,wire\n"), "listed only once"),
        (
            lambda: read_target_table("targets.csv", b"target,kind,nx,ny,nz\n1,plane,0,0,0\n"),
            "must not be a zero vector",
        ),
        (lambda: read_target_table("targets.csv", b"target,kind,nx\n1,plane,0\n"), "ny"),
        (lambda: distances("1,4,300,0.001"), "that have a centre: 1, 2"),
        (
            lambda: distances("4,4,300,0.001", targets=SPHERES[2:]),
            "that have a centre, of which there are none",
        ),
        (lambda: distances("1,1,300,0.001"), "two different targets"),
    ],
)  # fmt: skip
def test_what_cannot_be_meant_is_refused(read, words):
    with pytest.raises(InputFileError, match=words):
        read()


def test_a_table_of_contacts_judges_a_model_that_knows_its_targets():
    text = rows(HEADER, "1,10,4,1,0.25,0.002")

    found = held_out_readings("more.csv", text, 1, range(1, 4), SPHERES)

    assert found.readings.reading_mm.tolist() == [0.25]


def test_a_description_without_any_readings_names_contacts_among_those_it_may_have():
    campaign = make_contact_campaign()
    files = campaign_files(dataclasses.replace(campaign, contacts=None, validation_contacts=None))

    with pytest.raises(InputFileError, match="validation_contacts"):
        campaign_from(lambda name: files[name].encode())


def test_nothing_of_a_target_becomes_nan():
    assert "nan" not in campaign_files(make_contact_campaign())["targets.csv"]
    assert not math.isnan(make_contact_campaign().targets[1].zero_uncertainty_mm)
