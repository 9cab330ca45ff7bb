"""`truepose watch`: what is left in a folder is identified, once, when it is whole."""

import itertools
import json
import shutil

import pytest

from tests.helpers.checkout import CHECKOUT
from truepose.cli import batch_analysis
from truepose.cli.batch_analysis import watch_command
from truepose.domain.errors import ConfigurationError
from truepose.exchange.campaigns.points_with_joints import Stated, arrivals, read_stated
from truepose.exchange.errors import BadValueError, MissingFileError
from truepose.exchange.models.file import read_model

PAINTED_ELSEWHERE = pytest.mark.usefixtures("empty_pictures")
EXAMPLE = CHECKOUT / "docs/examples/campaign"


@pytest.fixture
def inbox(tmp_path):
    folder = tmp_path / "inbox"
    folder.mkdir()
    return folder


def left(inbox, name="arm-7"):
    return shutil.copytree(EXAMPLE, inbox / name)


def names(folder):
    return [arrival.name for arrival in arrivals(folder)]


@PAINTED_ELSEWHERE
def test_a_campaign_that_is_there_is_identified(inbox, tmp_path, capsys):
    left(inbox)

    assert watch_command(inbox, tmp_path / "results", once=True) == 0

    place = tmp_path / "results" / "arm-7"
    assert json.loads((place / "identification.json").read_text())["status"] == "converged"
    assert read_model(place / "model.json").robot.name == "ABB IRB 120, simulated"
    assert (place / "report.html").is_file()
    assert capsys.readouterr().out.startswith("arm-7: ")


@PAINTED_ELSEWHERE
def test_what_cannot_be_read_is_one_line_and_stops_nothing(inbox, tmp_path, capsys):
    left(inbox, "b-whole")
    (inbox / "a-broken.zip").write_bytes(b"no zip")

    assert watch_command(inbox, tmp_path / "results", once=True) == 1

    first, second = capsys.readouterr().out.strip().split("\n")
    assert first.startswith("a-broken: ")
    assert second.startswith("b-whole: ")


def test_an_empty_folder_gives_nothing(inbox, tmp_path, capsys):
    (inbox / "notes.pdf").write_bytes(b"%PDF")
    (inbox / "alone.txt").write_text("P1 1 2 3\n")  # no joints yet

    assert watch_command(inbox, tmp_path / "results", once=True) == 0
    assert capsys.readouterr().out == ""


def test_only_what_two_looks_find_alike_is_taken_and_only_once(inbox, monkeypatch):
    looks = itertools.count()

    def between(_seconds):
        number = next(looks)
        if number < 3:  # somebody copies for three looks
            (inbox / "slow.zip").write_bytes(b"x" * (number + 1))
        if number == 6:
            (inbox / "slow.zip").write_bytes(b"another measurement")
        if number == 9:
            raise KeyboardInterrupt

    monkeypatch.setattr(batch_analysis.time, "sleep", between)
    taken = []

    with pytest.raises(KeyboardInterrupt):
        taken.extend((arrival.name, arrival.states) for arrival in recorded(inbox, taken))

    assert [name for name, _ in taken] == ["slow", "slow"]
    assert [states[0][0] for _, states in taken] == [3, len(b"another measurement")]


def recorded(inbox, taken):
    for arrival in batch_analysis._whole(inbox, once=False):
        taken.append((arrival.name, arrival.states))
        yield from ()


def test_points_are_taken_with_their_joints_by_what_the_folder_states(inbox):
    (inbox / "line-1.txt").write_text("".join(f"C{n}_N1 {100 + n}.5 2 3\n" for n in range(1, 41)))
    rows = "".join(f"{n},{n},0,0,0,{n},0\n" for n in range(1, 41))
    (inbox / "line-1.joints.csv").write_text(f"config,{','.join(f'q{j}_deg' for j in range(1, 7))}\n{rows}")
    (inbox / "import.toml").write_text(
        'robot = "abb-irb-120"\nunit = "mm"\nu_mm = 0.03\nnames = "C{config}_*"\n'
    )

    (arrival,) = arrivals(inbox)

    assert arrival.name == "line-1"
    campaign = arrival.read()
    assert len(campaign.calibration) == 40
    assert campaign.calibration.position_mm[4].tolist() == [105.5, 2.0, 3.0]


def test_without_import_toml_a_list_is_refused_with_its_name(inbox):
    (inbox / "line-1.txt").write_text("P1 1 2 3\n")
    (inbox / "line-1.joints.csv").write_text("config,q1_deg\n1,2\n")

    (arrival,) = arrivals(inbox)

    with pytest.raises(MissingFileError, match=r"import\.toml"):
        arrival.read()


def test_what_is_stated_is_read_strictly(tmp_path):
    file = tmp_path / "import.toml"
    file.write_text('robot = "abb-irb-120"\nnests_mm = [[0, 0, 125]]\nnest_u_mm = 0.002\n')

    assert read_stated(file) == Stated("abb-irb-120", nests_mm=((0.0, 0.0, 125.0),), nest_u_mm=0.002)
    for wrong, said in (('unit = "yard"', "must be one of mm"), ("speed = 3", "the keys are names")):
        file.write_text(f'robot = "abb-irb-120"\n{wrong}\n')
        with pytest.raises(BadValueError, match=said):
            read_stated(file)


def test_a_folder_that_is_none_is_said_at_once(tmp_path):
    with pytest.raises(ConfigurationError, match="is not a folder; create it first"):
        watch_command(tmp_path / "nowhere", tmp_path / "results", once=True)
    assert names(tmp_path) == []
