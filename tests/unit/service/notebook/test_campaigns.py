"""Campaigns in a notebook: from a folder, a zip or tables, all the same to what follows."""

import json
import math

import numpy as np
import pytest

import truepose as tp
from tests.unit.service.notebook.conftest import EXAMPLES
from truepose.domain.errors import ConfigurationError
from truepose.exchange.campaigns.folder import campaign_files
from truepose.exchange.campaigns.zip_file import write_campaign_zip
from truepose.exchange.errors import BadValueError, MissingEntryError, UnknownRobotError

_KEYS = json.loads((EXAMPLES / "campaign" / "campaign.json").read_text(encoding="utf-8"))
_DRAWN = np.random.default_rng(0)
_READINGS = {
    "config": np.arange(8),
    "joints_rad": _DRAWN.uniform(-1.0, 1.0, (8, 6)),
    "nest": [1, 2] * 4,
    "position_mm": _DRAWN.uniform(300.0, 600.0, (8, 3)),
    "u_mm": 0.015,
}


def _from_frames(campaign):
    """The example campaign put together from its parts, as somebody with other sources would."""
    parts = ("masses", "gravity_m_s2_world", "notes", "simulated")
    return tp.read_campaign(
        campaign.to_frame(),
        robot=_KEYS["dhm_nominal"],
        validation=campaign.to_frame("validation"),
        nests_mm=_KEYS["tool_nests_mm"],
        nest_u_mm=_KEYS["tool_nest_u_mm"],
        base=_KEYS["base_in_world_nominal"],
        repeatability_mm=_KEYS["robot_repeatability_mm"],
        keys={"robot": _KEYS["robot"], **{name: _KEYS[name] for name in parts}},
    )


def test_frames_give_the_campaign_of_the_folder(campaign):
    pytest.importorskip("pandas")

    assert campaign_files(_from_frames(campaign).data) == campaign_files(campaign.data)


def test_a_zip_gives_the_campaign_of_the_folder(campaign, tmp_path):
    (tmp_path / "cell.zip").write_bytes(write_campaign_zip(campaign.data))

    assert campaign_files(tp.read_campaign(tmp_path / "cell.zip").data) == campaign_files(campaign.data)


def test_what_was_saved_reads_back(campaign, tmp_path):
    campaign.save(tmp_path / "again")

    assert campaign_files(tp.read_campaign(tmp_path / "again").data) == campaign_files(campaign.data)


def test_nests_and_base_that_nobody_states_are_unknown():
    data = tp.read_campaign(_READINGS, robot="abb-irb-120").data

    assert [nest.centre_mm for nest in data.nests] == [None, None]
    assert data.base_nominal is None
    assert data.calibration.standard_uncertainty_mm.tolist() == [0.015] * 8
    assert data.calibration.stops.joints_rad == pytest.approx(_READINGS["joints_rad"], abs=1e-15)


def test_a_shipped_robot_brings_its_limits_and_its_repeatability():
    robot = tp.read_campaign(_READINGS, robot="abb-irb-120").data.robot

    assert robot.joint_limits is not None
    assert robot.repeatability_mm > 0.0


def test_a_robot_may_be_a_file_or_a_table_of_arrays():
    table = {
        "alpha_rad": [math.radians(row["alpha_deg"]) for row in _KEYS["dhm_nominal"]],
        "a_mm": [row["a_mm"] for row in _KEYS["dhm_nominal"]],
        "theta_offset_deg": [row["theta_offset_deg"] for row in _KEYS["dhm_nominal"]],
        "d_mm": [row["d_mm"] for row in _KEYS["dhm_nominal"]],
    }

    of_table = tp.read_campaign(_READINGS, robot=table, repeatability_mm=0.02).data.robot
    of_file = tp.read_campaign(_READINGS, robot=EXAMPLES / "own_robot" / "acme-a6.toml").data.robot

    assert of_table.joints[1].alpha_rad == pytest.approx(-math.pi / 2, abs=1e-15)
    assert of_file.name == "ACME A6"


def test_lengths_make_a_campaign_of_legs():
    legs = {
        "placement": 1,
        "config": np.arange(8),
        "joints_rad": _READINGS["joints_rad"],
        "base_point": 1,
        "tool_point": 2,
        "length_mm": np.full(8, 300.0),
        "u_mm": 0.001,
    }

    campaign = tp.read_campaign(legs, robot="abb-irb-120", validation=legs)

    assert repr(campaign).endswith("6 joints, 2 nests; 8 calibration lengths, 8 validation lengths")


def test_readings_against_targets_make_a_campaign_of_contacts():
    contacts = {
        "config": np.arange(8),
        "joints_rad": _READINGS["joints_rad"],
        "target": 1,
        "nest": 1,
        "reading_mm": np.linspace(-1.0, 1.0, 8),
        "u_mm": 0.002,
    }
    targets = {"target": [1], "kind": ["sphere"], "zero_mm": [15.7]}

    campaign = tp.read_campaign(contacts, robot="abb-irb-120", tables={"targets": targets})

    assert repr(campaign).endswith("6 joints, 1 nest; 8 calibration contacts")
    assert campaign.data.targets[0].zero_mm == 15.7
    assert campaign.to_frame("targets")["kind"].tolist() == ["sphere"]


@pytest.mark.parametrize(
    ("changes", "arguments", "error", "sentence"),
    [
        (
            {},
            {},
            ConfigurationError,
            "Readings need a robot: give robot=..., the name of a shipped robot or the rows",
        ),
        (
            {},
            {"robot": "abb-irb-121"},
            UnknownRobotError,
            "No robot is called 'abb-irb-121'; the shipped",
        ),
        (
            {"u_mm": [0.015] * 7 + [math.nan]},
            {"robot": "abb-irb-120"},
            BadValueError,
            "calibration, row 7, column u_mm: the cell is empty; a number is required.",
        ),
        (
            {},
            {"robot": [{"alpha_deg": 0.0, "a_mm": 0.0, "theta_offset_deg": 0.0, "d_mm": 1.0}] * 6},
            MissingEntryError,
            "campaign: key robot_repeatability_mm is missing; it is required.",
        ),
        (
            {},
            {"robot": "abb-irb-120", "nests_mm": [[0.0, 1.0], None]},
            BadValueError,
            "campaign, key tool_nests_mm[0]: 2 entries found where 3 are required.",
        ),
        (
            {},
            {"robot": "abb-irb-120", "tables": {"referense": {}}},
            ConfigurationError,
            "A campaign has no table 'referense'; known tables: calibration,",
        ),
    ],
)
def test_what_cannot_be_meant_is_said_in_one_sentence(changes, arguments, error, sentence):
    with pytest.raises(error) as refused:
        tp.read_campaign(_READINGS | changes, **arguments)

    assert sentence in str(refused.value)
    assert isinstance(refused.value, tp.TrueposeError)


def test_a_column_that_is_not_understood_is_remarked_once():
    campaign = tp.read_campaign(_READINGS | {"shift": 2}, robot="abb-irb-120")

    assert campaign.remarks == ("calibration: column shift is not part of the format and is ignored.",)
    assert "column shift" in campaign._repr_html_()


def test_a_table_that_the_campaign_does_not_have_is_named(campaign):
    with pytest.raises(ConfigurationError, match="has no table 'legs'; it has calibration, validation"):
        campaign.to_frame("legs")
