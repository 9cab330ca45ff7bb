"""The example package of causes, as if it were installed: found, used, and harmless where it is broken."""

import json
import os
import subprocess
import sys
import tomllib
from dataclasses import replace
from importlib import import_module
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.checkout import SOURCES
from tests.helpers.diagnosis.point_scenes import telling_campaign, telling_scene
from tests.integration.documentation.hose_pull import tension
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.campaign import Campaign, PointReadings, Stops
from truepose.effects.causes import Signature
from truepose.effects.installed import GROUP, load_installed
from truepose.effects.unclassified.cause import KINDS
from truepose.effects.unclassified.kinds import Kind
from truepose.exchange.campaigns.folder import write_campaign
from truepose.exchange.robots.named import load_robot_with_tool
from truepose.kinematics.chain import nominal_chain

_CHECKOUT = Path(__file__).parents[3]
_PACKAGE = _CHECKOUT / "docs" / "examples" / "acme_causes"
_CAMPAIGN = _CHECKOUT / "docs" / "examples" / "campaign"
_ENTRIES = tomllib.loads((_PACKAGE / "pyproject.toml").read_text())["project"]["entry-points"][GROUP]


def installed(folder, entries, modules=()):
    """A distribution of some modules on a path of its own, with its entry points."""
    metadata = folder / "truepose_acme_causes-0.1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: truepose-acme-causes\nVersion: 0.1.0\n")
    lines = [f"{name} = {value}" for name, value in entries.items()]
    (metadata / "entry_points.txt").write_text("\n".join([f"[{GROUP}]", *lines, ""]))
    for name, text in dict(modules).items():
        (folder / f"{name}.py").write_text(text)
    return folder


def truepose(*arguments, beside):
    """Run the program where other packages are installed too."""
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        env={"PYTHONPATH": os.pathsep.join(map(str, (*SOURCES, *beside))), "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


def test_the_package_brings_a_named_cause_and_a_kind_of_cell(tmp_path):
    folder = installed(tmp_path / "site", _ENTRIES)
    asked = (
        "from truepose.effects.registry import CAUSES, unusable_causes; "
        "from truepose.effects.unclassified.cause import KINDS; "
        "from truepose.effects.signatures import signature_of; "
        "from truepose.effects.causes import Candidate; "
        "print('friction_windup' in CAUSES, 'daily' in KINDS, unusable_causes(), "
        "*signature_of(Candidate('friction_windup', 'joint 3', ())))"
    )

    done = truepose("-c", asked, beside=(folder, _PACKAGE))

    assert done.stdout.strip() == "True True () joint 3 torque of joint 3 sign", done.stderr


def test_what_a_package_brings_can_be_asked_for_by_name(tmp_path):
    folder = installed(tmp_path / "site", _ENTRIES)
    effects = ("--effects", "base,tool,geometry,friction_windup", "--json")

    done = truepose("-m", "truepose", "identify", _CAMPAIGN, *effects, beside=(folder, _PACKAGE))
    without = truepose("-m", "truepose", "identify", _CAMPAIGN, *effects, beside=())

    assert done.returncode == 0, done.stderr
    assert '"friction_3"' in done.stdout
    assert without.returncode == 2
    assert "Unknown effect 'friction_windup'" in without.stderr


def pulled_campaign(folder, pull, n=60):
    """A robot whose joint 5 a hose turns by `pull` of the angle beyond its slack; written as a folder."""
    shipped = load_robot_with_tool("abb-irb-120")
    rng = np.random.default_rng(0)
    joints, nest = rng.uniform(-1.2, 1.2, (n, 6)), rng.integers(1, 4, n)
    reached = joints.copy()
    reached[:, 4] += pull * tension(joints)
    centres = np.array([one.centre_mm for one in shipped.nests])
    places = nominal_chain(shipped.robot, reached).points(centres[nest - 1]) + rng.normal(0.0, 0.01, (n, 3))
    readings = PointReadings(Stops(np.arange(1, n + 1), joints), nest, places, np.full(n, 0.01))
    campaign = Campaign(shipped.robot, base_nominal=None, nests=shipped.nests, calibration=readings)
    write_campaign(campaign, folder)


def test_one_file_and_one_registration_take_an_effect_to_identification_diagnosis_and_report(tmp_path):
    """The file is `hose_pull.py`, the registration its entry point; nothing else knows of it."""
    pulled_campaign(tmp_path / "campaign", pull=1.5e-3)
    beside = (installed(tmp_path / "site", {"hose_pull": "hose_pull:EFFECT"}), Path(__file__).parent)
    report = tmp_path / "diagnosis.html"
    asked = ("-m", "truepose", "identify", tmp_path / "campaign", "--json")
    wanted = ("-m", "truepose", "diagnose", tmp_path / "campaign", "--json", "--report", report)

    identified = truepose(*asked, "--effects", "base,geometry,hose_pull", beside=beside)
    diagnosed = truepose(*wanted, beside=beside)

    assert (identified.returncode, diagnosed.returncode) == (0, 0), identified.stderr + diagnosed.stderr
    pull = next(p for p in json.loads(identified.stdout)["parameters"] if p["name"] == "pull_5")
    (finding,) = json.loads(diagnosed.stdout)["findings"]
    assert pull["value"] == pytest.approx(1.5e-3, abs=4.0 * pull["standard_uncertainty"])
    assert (finding["effect"], finding["subject"]) == ("hose_pull", "joint 5")
    assert finding["amplitude"] == pytest.approx(1.5e-3, abs=4.0 * finding["amplitude_standard_uncertainty"])
    assert (finding["where"], finding["over"], finding["shape"]) == ("joint 5", "angle of joint 4", "curve")
    page = report.read_text(encoding="utf-8")
    assert "hose pull" in page
    assert "A hose pulls at joint 5 where joint 4 turns far." in page


def test_a_broken_package_costs_one_sentence_and_nothing_else(tmp_path):
    modules = {"acme": "raise RuntimeError('no licence')"}
    folder = installed(tmp_path / "site", {"acme": "acme:BROUGHT"}, modules)

    done = truepose("-m", "truepose", "identify", _CAMPAIGN, beside=(folder,))
    asked = truepose("-m", "truepose", "identify", _CAMPAIGN, "--effects", "acme", beside=(folder,))

    told = "loading acme:BROUGHT failed with RuntimeError: no licence."
    assert done.returncode == 0
    assert done.stderr == f"The installed cause 'acme' is not used: {told}\n"
    assert asked.returncode == 2
    assert f"Effect 'acme' is installed but cannot be used: {told}" in asked.stderr


def test_a_name_that_truepose_has_stays_its_own(tmp_path):
    mine = (
        "from truepose.effects.arm.backlash import Backlash\n"
        "from truepose.effects.causes import Signature\n"
        "class Mine(Backlash):\n    signature = Signature('readings', 'time', 'jump')\n"
        "BROUGHT = Mine()\n"
    )
    folder = installed(tmp_path / "site", {"backlash": "mine:BROUGHT"}, {"mine": mine})
    asked = (
        "from truepose.effects.registry import CAUSES, unusable_causes; "
        "from truepose.effects.signatures import signature_of; "
        "from truepose.effects.causes import Candidate; "
        "print(type(CAUSES['backlash']).__name__, signature_of(Candidate('backlash', 'joint 3', ())).over, "
        "*unusable_causes())"
    )

    done = truepose("-c", asked, beside=(folder,))

    assert done.stdout == (
        "Backlash direction The installed cause 'backlash' is not used: "
        "truepose has its own cause of this name.\n"
    ), done.stderr


def test_a_cause_that_fails_while_it_works_is_named(tmp_path):
    looks, fails = "    time_s = scene.stops.time_s", "    return 1 / 0"
    daily = (_PACKAGE / "daily.py").read_text()
    assert looks in daily
    folder = installed(tmp_path / "site", {"daily": "daily:BROUGHT"}, {"daily": daily.replace(looks, fails)})

    done = truepose("-m", "truepose", "diagnose", _CAMPAIGN, beside=(folder,))

    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "The installed cause 'daily' failed with ZeroDivisionError: division by zero. Repair or remove the "
        "package that provides it. [TP-4017]"
    ]


@pytest.fixture
def daily(monkeypatch):
    """The kind of the example in the table, guarded as a package's."""
    monkeypatch.syspath_prepend(str(_PACKAGE))
    entry = EntryPoint("daily", _ENTRIES["daily"], GROUP)
    monkeypatch.setitem(KINDS, "daily", load_installed([entry]).kinds["daily"])
    yield KINDS["daily"]
    del sys.modules["daily"]


def over_a_day(n=80, amplitude_rad=0.0):
    """Readings once in half an hour, of an arm whose third joint follows the hour."""
    joints = telling_campaign(n).calibration.stops.joints_rad
    time_s = 1800.0 * np.arange(n)
    true = joints.copy()
    true[:, 2] += amplitude_rad * np.sin(2.0 * np.pi * time_s / 86_400.0 + 0.7)
    campaign = telling_campaign(n, joints_rad=true)
    points = campaign.calibration
    noise = 0.015 * np.random.default_rng(4).standard_normal((n, 3))
    stops = replace(points.stops, joints_rad=joints, time_s=time_s, direction=None, move_rad=None)
    calibration = replace(points, stops=stops, position_mm=points.position_mm + noise)
    return replace(campaign, calibration=calibration, reference=None)


def test_a_diagnosis_finds_what_the_package_looks_for(daily):
    diagnosis = diagnose(over_a_day(amplitude_rad=2e-4), ("base", "joint_offset"))

    (finding,) = diagnosis.findings
    assert (finding.where, finding.over, finding.shape) == ("joint 3", "time", "wave")
    assert finding.amplitude == pytest.approx(
        np.rad2deg(2e-4), abs=4.0 * finding.amplitude_standard_uncertainty
    )
    assert finding.sentence.startswith("The zero of joint 3 goes up and down by 0.01")


def test_a_diagnosis_of_a_sound_arm_finds_nothing_of_it(daily):
    assert diagnose(over_a_day(), ("base", "joint_offset")).findings == ()


def test_readings_of_an_hour_are_not_looked_at(daily):
    assert daily.places(telling_scene()) == ()


def test_both_entries_of_the_example_are_what_the_table_says(monkeypatch):
    monkeypatch.syspath_prepend(str(_PACKAGE))
    brought = [import_module(value.split(":")[0]).BROUGHT for value in _ENTRIES.values()]

    windup, kind = brought
    assert isinstance(windup.signature, Signature)
    assert isinstance(kind, Kind)
    for name in ("friction_windup", "daily"):
        del sys.modules[name]
