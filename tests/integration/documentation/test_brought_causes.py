"""The example package of causes, as if it were installed: found, used, and harmless where it is broken."""

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
from truepose.diagnosis.diagnose import diagnose
from truepose.effects.causes import NamedCause
from truepose.effects.installed import GROUP, load_installed
from truepose.effects.unnamed.kinds import Kind
from truepose.effects.unnamed.table import KINDS

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
        "from truepose.effects.unnamed.table import KINDS; from truepose.effects.cells import cell_of; "
        "from truepose.effects.causes import Candidate; "
        "print('friction_windup' in CAUSES, 'daily' in KINDS, unusable_causes(), "
        "*cell_of(Candidate('friction_windup', 'joint 3', ())))"
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
    assert "There is no effect 'friction_windup'" in without.stderr


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
        "from truepose.effects.joints.backlash import Backlash\n"
        "from truepose.effects.causes import CellRow, NamedCause\n"
        "BROUGHT = NamedCause(Backlash(), CellRow('readings', 'time', 'jump'))\n"
    )
    folder = installed(tmp_path / "site", {"backlash": "mine:BROUGHT"}, {"mine": mine})
    asked = (
        "from truepose.effects.registry import CAUSES, unusable_causes; "
        "from truepose.effects.cells import cell_of; from truepose.effects.causes import Candidate; "
        "print(type(CAUSES['backlash']).__name__, cell_of(Candidate('backlash', 'joint 3', ())).over, "
        "*unusable_causes())"
    )

    done = truepose("-c", asked, beside=(folder,))

    assert done.stdout == (
        "Backlash direction The installed cause 'backlash' is not used: "
        "truepose has one of that name itself.\n"
    ), done.stderr


def test_a_cause_that_fails_while_it_works_is_named(tmp_path):
    looks, fails = "    time_s = scene.stops.time_s", "    return 1 / 0"
    daily = (_PACKAGE / "daily.py").read_text()
    assert looks in daily
    folder = installed(tmp_path / "site", {"daily": "daily:BROUGHT"}, {"daily": daily.replace(looks, fails)})

    done = truepose("-m", "truepose", "diagnose", _CAMPAIGN, beside=(folder,))

    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "The installed cause 'daily' failed with ZeroDivisionError: division by zero. Mend or remove the "
        "package that brings it. [TP-4017]"
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

    assert [type(one) for one in brought] == [NamedCause, Kind]
    for name in ("friction_windup", "daily"):
        del sys.modules[name]
