"""`truepose fleet`: robots compared from a folder, what is kept of it, and what a new robot gains."""

import json
import shutil

import pytest

from tests.helpers.commands import answer as truepose
from tests.studies.fleet.archive import written_fleet


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """Two robots on two days: nothing changes in them."""
    folder = tmp_path_factory.mktemp("fleet") / "campaigns"
    written_fleet(folder, 1, robots=2, configurations=15, ageing=0, months=(0, 1))
    return folder


def test_where_nothing_changes_the_command_names_nothing_and_keeps_what_was_told(archive, tmp_path):
    files = {name: tmp_path / name for name in ("check.csv", "pooled.json", "new.csv", "fleet.html")}
    options = [f"--{name.partition('.')[0]}" for name in list(files)[:3]] + ["--report"]
    asked = [part for pair in zip(options, files.values(), strict=True) for part in pair]

    out = archive.parent / "out"
    status, said, remarks = truepose("fleet", archive, "--out", out, "--workers", 1, *asked)
    kept = {file.name: file.stat().st_mtime_ns for file in out.rglob("*.told")}
    written_fleet(tmp_path / "later", 1, robots=1, configurations=15, ageing=0, months=(2,))
    later = ("--checked", tmp_path / "later" / "robot-00-month-2")
    again, document, _ = truepose("fleet", archive, "--out", out, "--workers", 1, "--json", *later)

    assert (status, again) == (0, 0)
    assert "No significant change" in " ".join(said.split())
    assert "Measure robot 00 next. No robot needs measuring urgently" in " ".join(said.split())
    assert "causes in robot 00 has grown by" in remarks
    assert "Another robot of the type is predicted to reach a mean error of" in remarks
    assert len(files["new.csv"].read_text().splitlines()) == 16
    assert files["check.csv"].read_text().startswith("config,q1_deg,")
    assert "No significant change" in files["fleet.html"].read_text()
    found = json.loads(document)
    assert (found["robots"], found["campaigns"], found["changes"]) == (["robot 00", "robot 01"], 4, [])
    assert (found["first"], found["last"], found["simulated"]) == ("2026-03-02", "2026-04-01", True)
    assert all(one["size_mm"] >= one["best_mm"] > 0.0 for one in found["would_show"])
    assert [one["size_mm"] for one in found["drifts_would_show"]] == [None, None]  # of two days each
    assert "would have been detected with 95 % probability if it had reached these sizes" in " ".join(
        said.split()
    )
    assert (found["checked"]["robot"], found["checked"]["causes"][0]["told"]) == ("robot 00", False)
    assert found["checked"]["sentences"][0].startswith("None of the causes checked in robot 00 has grown")
    assert len(kept) == 4
    assert {file.name: file.stat().st_mtime_ns for file in out.rglob("*.told")} == kept

    status, _, said = truepose("identify", archive / "robot-01-month-1", "--fleet", files["pooled.json"])
    assert (status, said) == (0, "")
    other = tmp_path / "other.json"
    other.write_text(files["pooled.json"].read_text().replace("ABB IRB 120", "another"))
    status, _, said = truepose("identify", archive / "robot-01-month-1", "--fleet", other)
    assert status == 2
    assert "other.json is for robots of type another" in said


def test_a_table_says_what_campaigns_do_not_and_one_without_either_is_left_out(archive, tmp_path):
    mine = tmp_path / "mine"
    shutil.copytree(archive, mine)
    for folder in sorted(mine.iterdir()):
        file = folder / "campaign.json"
        document = json.loads(file.read_text())
        said = {"robot_serial_number", "instrument_serial_number", "measured_on"}
        file.write_text(json.dumps({key: value for key, value in document.items() if key not in said}))
    table = tmp_path / "visits.csv"
    rows = [f"robot-0{i}-month-{m},arm {i},tracker,2026-0{m + 1}-05" for i in (0, 1) for m in (0, 1)]
    table.write_text("\n".join(["campaign,robot,instrument,day", *rows[:3]]))

    kept = ("--out", tmp_path / "out", "--workers", 1)
    status, said, _ = truepose("fleet", mine, "--table", table, *kept, "--json")
    without, _, sentence = truepose("fleet", mine, *kept)

    assert status == 1
    found = json.loads(said)
    assert (found["robots"], found["instruments"], found["campaigns"]) == (["arm 0", "arm 1"], ["tracker"], 3)
    assert [one["campaign"] for one in found["left_out"]] == ["robot-01-month-1"]
    assert without == 2
    assert sentence.startswith("No campaign can be compared. robot-00-month-0: Not stated: robot_serial")


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ("campaign,robot,day\n", "column instrument is missing"),
        ("campaign,robot,instrument,day\nrobot-00-month-0,a,t,May\n", "'May' is not a date"),
        ("campaign,robot,instrument,day\nnobody,a,t,2026-05-01\n", "The table names campaign 'nobody'"),
        (
            "campaign,robot,instrument,day\nrobot-00-month-0,a,t,\nrobot-00-month-0,a,t,\n",
            "appears in two rows",
        ),
    ],
)
def test_a_table_that_cannot_be_meant_is_a_sentence(archive, tmp_path, rows, sentence):
    table = tmp_path / "visits.csv"
    table.write_text(rows)

    status, _, said = truepose("fleet", archive, "--table", table, "--workers", 1)

    assert status == 2
    assert sentence in said
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--type", "another"), "No campaign has robot type 'another'; available types: ABB IRB 120 (4)."),
        (("--limit", "0"), "--limit 0: give a size above 0 mm."),
        (("--growth", "-1"), "--growth -1: give a size above 0 mm."),
        (("--check", "nowhere/check.csv"), "the folder nowhere does not exist"),
    ],
)
def test_what_cannot_be_asked_is_a_sentence(archive, options, sentence):
    status, _, said = truepose("fleet", archive, "--out", archive.parent / "out", "--workers", 1, *options)

    assert status == 2
    assert sentence in said


def test_robots_that_were_measured_once_each_do_not_show_what_changes(archive, tmp_path):
    for folder in archive.glob("*-month-0"):
        shutil.copytree(folder, tmp_path / "once" / folder.name)

    status, _, said = truepose("fleet", tmp_path / "once", "--out", archive.parent / "out", "--workers", 1)

    assert status == 2
    assert said.startswith("2 robots were measured on one day each")
