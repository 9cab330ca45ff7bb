"""Campaigns survive being packed: every digit of every column, and nothing that was not there."""

import contextlib
import dataclasses
import io
import json
from datetime import date

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.domain.builders import make_ballbar_campaign, make_campaign
from truepose.domain.campaign import Campaign, FixedNestReadings
from truepose.domain.robot import WorldRegistration
from truepose.storage.documents import is_packed, pack, unpack
from truepose.storage.errors import DamagedDatabaseError


def differences(left, right, path="campaign"):
    """Return the paths at which two nouns differ; NaN equals NaN, and kinds of numbers count."""
    if dataclasses.is_dataclass(left) and type(left) is type(right):
        names = [field.name for field in dataclasses.fields(left)]
        return [d for n in names for d in differences(getattr(left, n), getattr(right, n), f"{path}.{n}")]
    if isinstance(left, np.ndarray):
        same = isinstance(right, np.ndarray) and left.dtype == right.dtype
        return [] if same and np.array_equal(left, right, equal_nan=left.dtype.kind == "f") else [path]
    return [] if left == right else [path]


def test_a_campaign_of_points_comes_back_with_every_digit():
    points = make_campaign().calibration
    count = len(points)
    stops = dataclasses.replace(
        points.stops,
        time_s=np.linspace(0.1, 1e6 / 3, count),
        temperature_c=np.full(count, np.nan),
        direction=np.tile([1, 0, -1, 1, 0, -1], (count, 1))[:, : points.stops.joints_rad.shape[1]],
    )
    campaign = make_campaign(
        calibration=dataclasses.replace(
            points,
            stops=stops,
            position_mm=points.position_mm + 1.0 / 3.0,
            covariance_mm2=np.tile(np.eye(3) / 3e4, (count, 1, 1)),
        ),
        reference=FixedNestReadings(np.array([0.5]), np.array([2]), np.eye(1, 3) / 7.0, np.array([0.01])),
        registration=WorldRegistration(np.eye(6) / 9.0),
        simulated=False,
        measured_on=date(2026, 3, 3),
        notes=("ß", '{"column": 1}'),
    )

    assert differences(unpack(Campaign, pack(campaign)), campaign) == []


def test_a_campaign_of_legs_comes_back():
    campaign = make_ballbar_campaign()

    assert differences(unpack(Campaign, pack(campaign)), campaign) == []


def test_the_comparison_of_this_file_sees_one_digit():
    campaign = make_campaign()
    moved = campaign.calibration.position_mm.copy()
    moved[-1, -1] = np.nextafter(moved[-1, -1], np.inf)
    other = make_campaign(calibration=dataclasses.replace(campaign.calibration, position_mm=moved))

    assert differences(other, campaign) == ["campaign.calibration.position_mm"]


def test_the_same_campaign_gives_the_same_bytes():
    assert pack(make_campaign()) == pack(make_campaign())


@pytest.mark.parametrize(
    "document", [[1], 7, {"fields": {"column": "one"}}, {"fields": {"column": [1]}}, {"column": None}]
)
def test_a_document_that_is_none_is_damaged(document):
    block = io.BytesIO()
    np.save(block, np.frombuffer(json.dumps(document).encode(), np.uint8))

    with pytest.raises(DamagedDatabaseError, match="A stored Campaign cannot be read"):
        unpack(Campaign, block.getvalue())


@pytest.mark.filterwarnings("ignore:Reading `.npy` or `.npz` file required additional header")
@given(place=st.integers(0), byte=st.integers(0, 255))
def test_whatever_byte_is_wrong_it_is_damaged_or_read(place, byte):
    data = bytearray(pack(make_campaign()))
    data[place % len(data)] = byte

    read = None
    with contextlib.suppress(DamagedDatabaseError):
        read = unpack(Campaign, bytes(data))

    assert read is None or isinstance(read, Campaign)


def test_what_is_packed_is_no_zip_and_a_zip_is_not_packed():
    assert is_packed(pack(make_campaign()))
    assert not is_packed(b"PK\x03\x04")
    assert not is_packed(b"")


@pytest.mark.parametrize("keep", [40, 500, -8, -1])
def test_what_was_cut_off_is_damaged(keep):
    with pytest.raises(DamagedDatabaseError, match="A stored Campaign cannot be read"):
        unpack(Campaign, pack(make_campaign())[:keep])


def test_what_holds_another_noun_is_damaged():
    with pytest.raises(DamagedDatabaseError, match="A stored Campaign cannot be read"):
        unpack(Campaign, pack(WorldRegistration(np.eye(6))))
