import re
from pathlib import Path

import pytest

import truepose_simulators
from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.kinds import BeamBroken, FixedNestMoved
from truepose_simulators.physics.effects import EFFECTS, PlantedChange
from truepose_simulators.physics.true_robot import PlantSizes
from truepose_simulators.scenarios.file import load_scenario, shipped_scenarios
from truepose_simulators.scenarios.scenario import Scenario


@pytest.fixture
def write(tmp_path):
    def write_file(text, name="mine.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write_file


def test_the_shipped_scenarios_are_there():
    assert shipped_scenarios() == [
        "irb120-camera",
        "irb120-camera-spatial",
        "irb120-clean",
        "irb120-curves",
        "irb120-everyday",
        "irb120-probe",
        "irb120-rws",
        "irb120-thesis",
        "irb120-tilted",
        "kr6-clean",
        "lrmate-ball-sensor",
        "lrmate-clean",
        "lrmate-everyday",
        "lrmate-fanuc",
        "lrmate-plane",
        "lrmate-rmi",
        "lrmate-sphere",
        "lrmate-three-gauges",
        "lrmate-tilted",
        "lrmate-two-spheres",
        "lrmate-wires",
        "ur10-clean",
    ]


@pytest.mark.parametrize("name", shipped_scenarios())
def test_every_shipped_scenario_can_be_read(name):
    assert load_scenario(name).name == name


def test_the_documented_scenario_states_the_values_that_absent_keys_have():
    shown = load_scenario("irb120-tilted")

    assert shown == Scenario(name="irb120-tilted", robot="irb120")


def test_clean_differs_from_tilted_in_the_tilt_alone():
    assert load_scenario("irb120-clean").errors == PlantSizes(parallel_axis_tilt_rad=0.0)
    assert load_scenario("lrmate-clean").errors == PlantSizes(parallel_axis_tilt_rad=0.0)


def test_a_file_of_ones_own_builds_on_another_key_by_key(write):
    path = write(
        """
        extends = "irb120-clean"
        noise = false
        [tracker]
        two_face_rad = 2e-6
        [[effect]]
        name = "joint_gain"
        subject = "joint 3"
        amplitude = 1e-3
        [[fault]]
        kind = "beam_broken"
        reading = 5
        [[fault]]
        kind = "fixed_nest_moved"
        nest = 2
        by_mm = [0.1, 0, 0]
        from_s = 100
        """
    )

    scenario = load_scenario(path)

    assert scenario.name == "mine"
    assert not scenario.noise
    assert scenario.errors.parallel_axis_tilt_rad == 0.0
    assert scenario.tracker.two_face_rad == 2e-6
    assert scenario.tracker.along_mm == 0.008
    assert scenario.effects == (PlantedChange("joint_gain", "joint 3", 1e-3, 0.0),)
    assert scenario.faults == (BeamBroken(reading=5), FixedNestMoved(2, (0.1, 0.0, 0.0), from_s=100.0))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", 'mine.toml: key "robot" is missing'),
        ('robot = "puma"', 'mine.toml: unknown robot "puma"; known: irb120, kr6r900, lrmate200ic'),
        ("robot = 120", 'mine.toml: key "robot" must be a text, not 120'),
        ("robot = ", "mine.toml is not TOML"),
        ('robot = "irb120"\nnoise = 0', 'mine.toml: key "noise" must be true or false, not 0'),
        ('robot = "irb120"\ncolour = 1', 'mine.toml: unknown key "colour"; known: robot, noise'),
        ('robot = "irb120"\n[arm]\nscater_mm = 1', 'mine.toml: [arm]: unknown key "scater_mm"; known:'),
        ('robot = "irb120"\n[arm]\nscatter_mm = "1"', "[arm]: key \"scatter_mm\" must be a number, not '1'"),
        ('robot = "irb120"\n[arm]\nscatter_mm = nan', 'key "scatter_mm" must be a finite number, not nan'),
        ('robot = "irb120"\n[arm]\nscatter_mm = -1', '[arm]: key "scatter_mm" must be 0 or more, not -1.0'),
        ('robot = "irb120"\n[arm]\nrefusal = "cry"', 'key "refusal" must be "hang" or "drop", not "cry"'),
        ('robot = "irb120"\narm = 3', "mine.toml: [arm] must be a table of keys, not 3"),
        ('robot = "irb120"\n[air]\nwave_period_s = 0', 'key "wave_period_s" must be above 0'),
        ('robot = "irb120"\n[base]\nrotation_rad = [0, 0]', 'key "rotation_rad" must have 3 entries, not 2'),
        (
            'robot = "irb120"\n[errors]\ncompliance_factor = [2, 1]',
            'key "compliance_factor" must be a rising range',
        ),
        ('robot = "irb120"\n[[link]]\njoint = 7', 'mine.toml: [[link]] number 1: key "joint" must be 1 to 6'),
        ('robot = "irb120"\n[link]\njoint = 1', "[[link]] must be a list of tables, written with double"),
        ('robot = "irb120"\n[[effect]]\nname = "x"', '[[effect]] number 1: key "subject" is missing'),
        (
            'robot = "irb120"\n[[effect]]\nname = "x"\nsubject = "y"\namplitude = 1',
            'mine.toml: [[effect]] number 1: unknown effect "x"; known: axis_parallelism, ',
        ),
        ('robot = "irb120"\n[[fault]]\nkind = "flood"', "key \"kind\" must be one of beam_broken"),
        ('robot = "irb120"\n[[fault]]\nkind = "smr_missing"', '[[fault]] number 1: key "nest" is missing'),
        ('robot = "irb120"\n[[fault]]\nkind = ["x"]', "key \"kind\" must be one of beam_broken"),
        ('robot = "irb120"\n[[fault]]\nkind = "tracker_cut"\nreading = 0', 'key "reading" must be 1 or more'),
        ('robot = "irb120"\n[[fault]]\nkind = "smr_missing"\nnest = 4', 'key "nest" must be 1 to 3, not 4'),
        ('robot = "irb120"\n[arm]\nhome_deg = [0, 0, 0]', 'key "home_deg" must have 6 entries'),
        ('robot = "irb120"\n[arm]\nhome_deg = [0, 0, 100, 0, 0, 0]', 'key "home_deg": joint 3 cannot go to'),
        ('extends = "mine.toml"', 'no scenario "mine.toml"'),
        ('robot = "irb120"\n[tool]\nfacing = [[0, 0, 1]]', 'keys "nests_mm" and "facing" must have the same'),
    ],
)  # fmt: skip
def test_a_mistake_is_answered_with_one_sentence_that_names_file_and_key(write, text, sentence):
    with pytest.raises(ScenarioError) as caught:
        load_scenario(write(text))

    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_scenario_that_extends_itself_is_refused(write, tmp_path):
    path = write(f'extends = "{tmp_path}/mine.toml"')

    with pytest.raises(ScenarioError, match="refers back to the file itself"):
        load_scenario(path)


def test_an_unknown_name_is_answered_with_the_shipped_ones():
    with pytest.raises(ScenarioError, match="neither a file nor one of irb120-camera, irb120-camera-spatial"):
        load_scenario("irb6600")


def test_planted_changes_and_faults_add_to_those_of_the_extended_file(write):
    planted = '[[effect]]\nname = "{}"\nsubject = "joint 3"\namplitude = 1e-3\n[[fault]]\nkind = "{}"\n'
    below = write(
        'extends = "irb120-clean"\n' + planted.format("joint_gain", "tracker_blinded"), "below.toml"
    )
    above = write(f'extends = "{below}"\n' + planted.format("joint_coupling", "tracker_blinded"))

    scenario = load_scenario(above)

    assert [effect.name for effect in scenario.effects] == ["joint_gain", "joint_coupling"]
    assert len(scenario.faults) == 2


def test_details_of_a_planted_change_are_read_and_checked(write):
    wave = '[[effect]]\nname = "joint_harmonics"\nsubject = "joint 6"\namplitude = 0.03\n'
    planted = 'extends = "irb120-clean"\n' + wave

    (change,) = load_scenario(write(planted + "order = 2\nphase_deg = 30.5")).effects

    assert change.details == {"order": 2, "phase_deg": 30.5}
    with pytest.raises(ScenarioError, match=r'mine.toml: \[\[effect\]\] number 1: .* unknown key "orden"'):
        load_scenario(write(planted + "orden = 2"))


def test_the_readme_lists_every_effect():
    readme = (Path(truepose_simulators.__file__).with_name("README.md")).read_text(encoding="utf-8")
    section = readme.split("## Effects", 1)[1].split("\n## ", 1)[0]

    listed = re.findall(r"^\| `([a-z_]+)` \|", section, re.MULTILINE)

    assert sorted(listed) == sorted(EFFECTS)
