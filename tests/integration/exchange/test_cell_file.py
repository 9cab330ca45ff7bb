"""A cell file says what it says, or is refused at the key that is wrong."""

import math
from itertools import combinations
from pathlib import Path

import pytest

from truepose.domain.cell import Artefact, Bars, CertifiedLength, PlantedEffect, SimulatedCell
from truepose.exchange.cells.file import read_cell, simulated_cell
from truepose.exchange.errors import (
    BadValueError,
    InputFileError,
    MissingEntryError,
    MissingFileError,
    UnknownRobotError,
    UnreadableFileError,
    WrongUnitError,
)
from truepose_drivers.registry import load_registry

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
REAL, SIMULATED = (
    (EXAMPLES / f"{kind}-cell.toml").read_text(encoding="utf-8") for kind in ("real", "simulated")
)


def read(folder, text):
    path = folder / "cell.toml"
    path.write_text(text, encoding="utf-8")
    return read_cell(path)


_PAGE = (EXAMPLES.parent / "cell-file.md").read_text(encoding="utf-8")
_SECTIONS = (
    "", "[tool]", "[world]", "[tracker]", "[limits]", "[conditions]", "[ballbar]", "[ballbar.base_bars]",
    "[ballbar.instrument]", "[simulated]", "[[fixed_nest]]",
)  # fmt: skip


@pytest.mark.parametrize("section", _SECTIONS)
def test_every_key_that_a_section_takes_is_on_the_page(section, tmp_path):
    with pytest.raises(InputFileError) as refused:
        read(tmp_path, f'robot = "abb-irb-120"\n{section}\nno_such_key = 1\n')

    keys = str(refused.value).partition("the keys here are ")[2].rstrip(".").split(", ")
    assert [key for key in keys if key not in _PAGE] == []
    assert keys != [""]


def test_the_example_of_a_real_cell_is_read_whole(tmp_path):
    cell = read(tmp_path, REAL)
    kit = cell.ballbar

    assert (cell.name, cell.robot_key, cell.robot.name) == ("Cell 3", "abb-irb-120", "ABB IRB 120")
    tracker, robot, ballbar = cell.devices
    assert (ballbar.driver, ballbar.options) == ("heidenhain_nd", {"serial": "/dev/ttyUSB0"})
    assert (tracker.name, tracker.driver) == ("tracker", "leica_emscon")
    assert tracker.options == {"host": "192.168.0.1", "port": 700}
    assert (tracker.serial_number, robot.driver) == ("391234", "abb_open_abb")
    assert [nest.centre_mm[0] for nest in cell.nests] == [0.0, 75.0, 150.0]
    assert cell.fixed_nests[2].centre_mm == (-350.0, 500.0, 0.0)
    assert cell.certified_lengths == (CertifiedLength((1, 2), 1000.003, 0.001),)
    assert cell.tracker_position_mm == (2600.0, -700.0, 500.0)
    assert cell.limits.joints[2].upper_rad == math.radians(70)
    assert cell.limits.reference_mm == 0.05
    assert cell.limits.orientation_speed_rad_s == math.radians(20.0)
    assert cell.conditions.warm_up.startswith("60 min")
    assert cell.tool.serial_number == "TA-07"
    assert cell.world.certificate.startswith("CMM report")
    assert cell.simulated is None
    assert kit.base_points == 4
    assert kit.base_bars == Bars(300.0, 300.0012, 0.0004, (150.0, 50.0))
    assert kit.tool_bars == Bars(150.0, 150.0318, 0.0004, (50.0,))
    assert kit.instrument == Artefact("ballbar", "L20042", "certificate 5512", "2027-03-31")
    assert kit.calibrator.serial_number == "C118"
    assert (kit.range_mm, kit.setup_u_mm) == (1.0, 0.01)


def test_the_example_gauges_are_devices_that_their_drivers_open(tmp_path):
    gauges = (EXAMPLES / "gauges.toml").read_text(encoding="utf-8")

    cell = read(tmp_path, f'robot = "abb-irb-120"\n{gauges}')

    drivers = load_registry()
    kinds = [drivers.kind(device.driver, device.use) for device in cell.devices]
    assert kinds == ["linear_gauge", "linear_gauge", "ballbar"]
    for device in cell.devices:
        assert drivers.open(device.driver, device.options, use=device.use) is not None


def test_the_example_of_a_simulated_cell_is_read_whole(tmp_path):
    cell = read(tmp_path, SIMULATED)

    effect = PlantedEffect("joint_gain", "joint 2", 1e-3, 600.0)
    assert cell.simulated == SimulatedCell("irb120-tilted", 7, (effect,))
    assert cell.devices == ()
    assert len(cell.nests) == 3  # the robot file's own tool


def test_what_a_simulated_cells_file_leaves_out_is_the_shipped_table(tmp_path):
    cell = read(tmp_path, '[simulated]\nscenario = "irb120-clean"\npace = 0\n')

    shipped = simulated_cell("irb120-clean", 0)
    assert (cell.robot.name, cell.simulated.pace) == (shipped.robot.name, 0)
    assert (cell.fixed_nests, cell.tool) == (shipped.fixed_nests, shipped.tool)
    assert cell.tracker_position_mm == shipped.tracker_position_mm


def test_a_table_of_ones_own_in_a_simulated_cell_gets_nothing_of_the_shipped_one(tmp_path):
    text = '[[fixed_nest]]\ncentre_mm = [1.0, 2.0, 3.0]\nu_mm = 0.1\n[simulated]\nscenario = "irb120-clean"\n'

    cell = read(tmp_path, text)

    assert len(cell.fixed_nests) == 1
    assert cell.tracker_position_mm is None


def test_a_pace_that_is_neither_real_time_nor_none_is_refused(tmp_path):
    with pytest.raises(BadValueError, match="the pace must be 1"):
        read(tmp_path, '[simulated]\nscenario = "irb120-clean"\npace = 2\n')


def test_a_tool_of_another_mass_replaces_the_robot_files(tmp_path):
    cell = read(tmp_path, REAL.replace("mass_kg = 2.7", "mass_kg = 1.5"))

    assert [(mass.frame, mass.mass_kg) for mass in cell.robot.masses] == [(2, 4.2), (4, 5.0), (6, 1.5)]


def test_a_robot_of_ones_own_is_read_from_beside_the_cell_file(tmp_path):
    (tmp_path / "mine.toml").write_text(
        'name = "mine"\nmasses = []\nrobot_repeatability_mm = 0.02\n'
        "dhm_nominal = [{joint = 1, alpha_deg = 0, a_mm = 0, theta_offset_deg = 0, d_mm = 100}]\n"
    )

    cell = read(tmp_path, 'robot = "mine.toml"\n[simulated]\nscenario = "mine.toml"\n')

    assert (cell.name, cell.robot.n_joints, cell.simulated.seed) == ("mine", 1, 0)


def test_places_where_the_tracker_was_aimed_are_kept(tmp_path):
    seen = "fixed_nests_seen_mm = [[1, 2, 3], [4, 5, 6], [7, 8, 9]]"

    cell = read(tmp_path, REAL.replace("position_mm = [2600.0, -700.0, 500.0]", seen))

    assert cell.fixed_nests_seen_mm == ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), (7.0, 8.0, 9.0))
    assert cell.tracker_position_mm is None


REFUSED = {
    "an unknown robot": ('"abb-irb-120"', '"abb-irb-9"', "robot", "the shipped ones are abb-irb-120"),
    "a mistyped section": ("[limits]", "[limit]", "limit", "unknown key; the keys here are"),
    "a mistyped limit": ("joints_deg", "joint_deg", "limits.joint_deg", "unknown key; the keys here are"),
    "limits in radians": ("joints_deg", "joints_rad", "limits.joints_rad", "joints_deg"),
    "limits wider than the robot's own": (
        "[-110, 110]",
        "[-110, 111]",
        "limits.joints_deg[1]",
        "joint 2 would go from -110 to 111 deg, but the limits of the ABB IRB 120 are -110 to 110 deg",
    ),
    "configurations chosen beyond the robot": (
        "[0, 90]",
        "[-120, 90]",
        "limits.calibration_deg[1]",
        "stay within them",
    ),
    "people that nobody could read": (
        'robot = "abb-irb-120"',
        'robot = "abb-irb-120"\npeople = ["Ada", "\u200b"]',
        "people[1]",
        "U+200B",
    ),
    "people without anybody": (
        'robot = "abb-irb-120"',
        'robot = "abb-irb-120"\npeople = []',
        "people",
        "nobody could confirm",
    ),
    "limits of five joints": ("[-165, 165], ", "", "limits.joints_deg", "5 entries found where 6"),
    "limits upside down": ("[-165, 165]", "[165, -165]", "limits.joints_deg[0]", "is not below"),
    "a driver that is missing": ('driver = "leica_emscon"', "", "device[0]", "driver is missing"),
    "a device without a name": ('name = "tracker"', "", "device[0]", "key name is missing"),
    "two devices of a name": ('name = "robot"', 'name = "tracker"', "device[1].name", "two devices"),
    "two addresses": ("port = 700", 'serial = "COM3"', "device[0]", "host and serial; keep one"),
    "a port beyond all": ("port = 700", "port = 70000", "device[0].port", "between 1 and 65535"),
    "a port that is text": ("port = 700", 'port = "700"', "device[0].port", "is not a number"),
    "an option that is a list": ("port = 700", "rate = [1]", "device[0].rate", "an option of a"),
    "a nest in metres": ("u_mm = 0.002\nfacing", "u_m = 2e-6\nfacing", "tool_nest[0].u_m", "u_mm"),
    "a direction of length 2": ("[-0.799,", "[-1.9,", "tool_nest[0].facing", "unit vector"),
    "a length to a nest that is none": (
        "fixed_nests = [1, 2]",
        "fixed_nests = [1, 4]",
        "certified_length[0].fixed_nests[1]",
        "between 1 and 3",
    ),
    "a length of one nest": (
        "fixed_nests = [1, 2]",
        "fixed_nests = [2, 2]",
        "certified_length[0].fixed_nests",
        "two different nests",
    ),
    "a mass without a centre": ("cog_mm = [50.0, 25.0, 100.0]", "", "tool", "cog_mm is missing"),
    "a speed of 0": ("tool_speed_mm_s = 500.0", "tool_speed_mm_s = 0", "limits.tool_speed_mm_s", "0"),
    "a speed that no arm is measured at": (
        "tool_speed_mm_s = 500.0",
        "tool_speed_mm_s = 1e9",
        "limits.tool_speed_mm_s",
        "1e+09 mm/s is too fast for measuring; the limit is 2000 mm/s",
    ),
    "planted changes in a real cell": (
        "[conditions]",
        '[[effect]]\nname = "joint_gain"\namplitude = 1\n[conditions]',
        "effect",
        "only in a simulated cell",
    ),
    "a simulated clock beside real devices": (
        "[[device]]",
        '[[device]]\nname = "clock"\ndriver = "cell_clock"\nhost = "10.0.0.9"\nport = 9000\n\n[[device]]',
        "device[1]",
        "must not be mixed",
    ),
    "devices of a simulated cell": (
        "[conditions]",
        '[simulated]\nscenario = "irb120-tilted"\n[conditions]',
        "simulated",
        "either simulated or has devices",
    ),
}
KINDS = {
    "a driver that is missing": MissingEntryError,
    "a device without a name": MissingEntryError,
    "a nest in metres": WrongUnitError,
    "a mass without a centre": MissingEntryError,
}  # else a value that cannot be meant


def test_a_planted_change_may_say_more_than_its_amplitude(tmp_path):
    details = 'order = 2\nsource = "joint 5"\naxis = [0, 0.5, 1]\n'

    cell = read(tmp_path, SIMULATED + details)

    assert cell.simulated.effects[0].details == {"order": 2.0, "source": "joint 5", "axis": (0.0, 0.5, 1.0)}


@pytest.mark.parametrize("detail", ["order = true", 'axis = ["x"]', "order = nan", "wave = {order = 2}"])
def test_a_detail_is_a_number_a_text_or_a_list_of_numbers(tmp_path, detail):
    with pytest.raises(BadValueError) as refusal:
        read(tmp_path, SIMULATED + detail)

    assert refusal.value.key.startswith("effect[0]." + detail.split(" ")[0])


@pytest.mark.parametrize("case", REFUSED)
def test_a_mistake_in_a_cell_file_is_refused_where_it_is(case, tmp_path):
    old, new, key, sentence = REFUSED[case]
    assert old in REAL

    with pytest.raises(KINDS.get(case, BadValueError)) as refusal:
        read(tmp_path, REAL.replace(old, new, 1))

    assert (refusal.value.file, refusal.value.key) == ("cell.toml", key)
    assert sentence in str(refusal.value)


def test_a_cell_without_anything_to_measure_with_is_refused(tmp_path):
    with pytest.raises(MissingEntryError, match="neither devices nor a simulation"):
        read(tmp_path, 'robot = "abb-irb-120"\n')


def test_a_mistake_of_toml_is_refused_with_its_line(tmp_path):
    with pytest.raises(UnreadableFileError, match=r"this is not TOML: .*line 2"):
        read(tmp_path, 'robot = "abb-irb-120"\nname = \n')


def test_a_cell_file_that_is_not_there_is_named_and_a_folder_is_none(tmp_path):
    with pytest.raises(MissingFileError, match=r"cell.toml: there is no such file\."):
        read_cell(tmp_path / "cell.toml")
    with pytest.raises(InputFileError, match="this is a folder, not a file"):
        read_cell(tmp_path)


@pytest.mark.parametrize(
    ("scenario", "robot"),
    [
        ("irb120-tilted", "abb-irb-120"),
        ("lrmate-clean", "fanuc-lr-mate-200ic"),
        ("ur10-clean", "universal-robots-ur10"),
        ("kr6-clean", "kuka-kr-6-r900-sixx"),
        ("x/irb120-mine.toml", "abb-irb-120"),
    ],
)
def test_a_simulated_cell_knows_its_robot_from_the_scenario(scenario, robot):
    cell = simulated_cell(scenario, 3)

    assert cell.robot_key == robot
    assert cell.simulated == SimulatedCell(scenario, 3)
    assert (len(cell.nests), len(cell.fixed_nests)) == (3, 3)
    assert cell.robot.masses[-1].mass_kg == 2.7


def test_a_scenario_of_an_unknown_robot_needs_a_cell_file():
    with pytest.raises(
        UnknownRobotError,
        match=r"begin its name with irb120\.\.\. or lrmate\.\.\. or ur10\.\.\. or kr6\.\.\.",
    ):
        simulated_cell("kr10-clean", 0)


BALLBAR = 'robot = "abb-irb-120"\n[simulated]\nscenario = "irb120-tilted"\n[ballbar]\n'


@pytest.mark.parametrize("scenario", ["irb120-tilted", "lrmate-tilted", None])
def test_no_side_of_a_shipped_cell_is_as_long_as_the_calibrator(tmp_path, scenario):
    found = read(tmp_path, REAL) if scenario is None else simulated_cell(scenario, 0)
    centres = [nest.centre_mm for nest in found.nests]
    sides = [math.dist(one, other) for one, other in combinations(centres, 2)]
    apart = min(abs(side - found.ballbar.tool_bars.calibrator_mm) for side in sides)

    assert apart > 4.0 * found.ballbar.zero_u_mm


def test_expansions_and_the_temperature_of_the_part_are_read_where_they_are_stated(tmp_path):
    warm = REAL.replace("length_mm = 1000.003", "length_mm = 1000.003\nexpansion_per_k = 1.15e-5")
    warm = warm.replace("calibrator_u_mm = 0.0004", "calibrator_u_mm = 0.0004\nexpansion_per_k = 0.0")
    warm = warm.replace("[conditions]", "[conditions]\npart_temperature_c = 21.4")
    stated, silent = read(tmp_path, warm), read(tmp_path, REAL)

    assert stated.certified_lengths[0].expansion_per_k == 1.15e-5
    assert stated.ballbar.base_bars.expansion_per_k == 0.0
    assert stated.conditions.part_temperature_c == 21.4
    assert silent.certified_lengths[0].expansion_per_k is None
    assert silent.conditions.part_temperature_c is None


def test_a_simulated_cell_has_a_ballbar_or_one_of_its_own_and_a_real_one_only_if_it_says_so(tmp_path):
    device = 'robot = "abb-irb-120"\n[[device]]\nname = "robot"\ndriver = "abb_open_abb"\nhost = "x"\n'

    assert simulated_cell("lrmate-tilted", 0).ballbar.base_points == 3
    assert read(tmp_path, device).ballbar is None
    kit = read(tmp_path, BALLBAR + "base_points = 4\nzero_u_mm = 0.002\n").ballbar
    assert (kit.base_points, kit.zero_u_mm) == (4, 0.002)


@pytest.mark.parametrize(
    ("line", "key", "what"),
    [
        ("base_points = 5", "ballbar.base_points", "5"),
        ("range_mm = -1.0", "ballbar.range_mm", "-1"),
        ("rnage_mm = 1.0", "ballbar.rnage_mm", "unknown key"),
        ("base_bars = {nominal_mm = 300.0}", "ballbar.base_bars", "calibrator_mm"),
        ('instrument = {certificate_expires = "31.3.2027"}', "certificate_expires", "2027-01-31"),
    ],
)
def test_a_mistake_in_the_ballbar_is_refused_at_its_key(tmp_path, line, key, what):
    with pytest.raises(InputFileError) as refused:
        read(tmp_path, BALLBAR + line + "\n")

    assert key in str(refused.value)
    assert what in str(refused.value)
