"""Files of faults: what is read, and which line a mistake is named with."""

import re

import pytest

from tests.helpers.checkout import CHECKOUT
from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.file import read_faults
from truepose_simulators.faults.kinds import KINDS, BeamBroken, EmergencyStop, LinkCut, SmrMissing
from truepose_simulators.scenarios.file import load_scenario

IRB120 = load_scenario("irb120-clean")
GOOD = """# a bad morning
[[fault]]
kind = "beam_broken"
configuration = 12

[[fault]]
kind = "emergency_stop"
move = 7
after_s = 0.4
for_s = 60

[[fault]]
kind = "link_cut"
device = "robot"
from_s = 300
for_s = 8
"""


@pytest.fixture
def read(tmp_path):
    def read_text(text):
        path = tmp_path / "morning.toml"
        path.write_text(text)
        return read_faults(path, IRB120.check_fault)

    return read_text


def test_a_file_is_its_faults_in_their_order(read):
    assert read(GOOD) == (
        BeamBroken(configuration=12),
        EmergencyStop(move=7, after_s=0.4, for_s=60.0),
        LinkCut(device="robot", from_s=300.0, for_s=8.0),
    )


def test_a_file_without_faults_has_none(read):
    assert read("# a good morning\n") == ()


def test_tables_written_in_one_line_are_read_too(read):
    assert read('fault = [{kind = "smr_missing", nest = 2}]') == (SmrMissing(nest=2),)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (GOOD.replace('"beam_broken"', '"flood"'), 'morning.toml, line 3: key "kind" must be one of beam'),
        (GOOD.replace("configuration = 12", "configuration = 0"), 'line 4: key "configuration" must be 1 or'),
        (
            GOOD.replace("after_s = 0.4", 'after_s = "0.4"'),
            "line 9: key \"after_s\" must be a number, not '0.4'",
        ),
        (GOOD.replace("move = 7", "mov = 7"), 'line 8: unknown key "mov"; known: '),
        (GOOD.replace('device = "robot"\n', ""), 'line 12: key "device" is missing'),
        (GOOD.replace('"robot"', '"lamp"'), 'line 14: key "device" must be one of tracker, robot'),
        (
            GOOD.replace("from_s = 300", "from_s = 300\nmove = 2"),
            "line 12: keys 'from_s' and 'move': a fault",
        ),
        (GOOD + '[[fault]]\nkind = "smr_missing"\nnest = 9', 'line 19: key "nest" must be 1 to 3, not 9'),
        (GOOD + "[fault\n", r"morning.toml is not TOML: .*line 17"),
        ('robot = "irb120"\n' + GOOD, 'line 1: unknown key "robot"; a fault file contains'),
        ('[fault]\nkind = "beam_broken"', "line 1: write [[fault]] with double brackets"),
        ("fault = [3]", 'line 1: key "kind" must be one of'),
    ],
)
def test_a_mistake_is_one_sentence_with_its_line(read, text, sentence):
    pattern = sentence if r".*" in sentence else re.escape(sentence)

    with pytest.raises(ScenarioError, match=pattern) as refused:
        read(text)

    assert "\n" not in str(refused.value)


def test_a_file_that_is_none_is_named(tmp_path):
    with pytest.raises(ScenarioError, match="cannot be read"):
        read_faults(tmp_path, IRB120.check_fault)


def test_every_kind_has_its_entry_and_an_example_in_the_documentation(read):
    text = (CHECKOUT / "docs" / "faults.md").read_text()

    examples = read((CHECKOUT / "docs" / "examples" / "faults.toml").read_text())

    assert {name for name in KINDS if f"| `{name}` |" not in text} == set()
    assert {type(fault) for fault in examples} == set(KINDS.values())
