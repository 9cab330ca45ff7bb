"""The study of hostile input to the drivers counts what happened, and writes it down."""

import json
import sys

from tests.contract.devices.machines import Controller, HandsOfPerson
from tests.studies.hardening.hostile_wires import main
from truepose_drivers.contract import hostile
from truepose_drivers.contract.wire_faults import GENERAL


def test_a_study_has_right_and_refused_answers():
    tally = hostile.tally(HandsOfPerson, 300, seed=7)

    assert tally.inputs == 300
    assert tally.right > 150  # the good line behind each fault
    assert tally.refused > 30


def test_the_same_seed_gives_the_same_study():
    first, second = (hostile.tally(Controller, 50, seed=11) for _ in range(2))

    assert (first.right, first.refused) == (second.right, second.refused)


def test_every_fault_says_what_it_is():
    assert all(spoil.__doc__ for spoil in GENERAL)


def test_the_study_writes_what_it_found(tmp_path, monkeypatch, capsys):
    arguments = [
        "--bytes",
        "50",
        "--runs",
        "20",
        "--faults",
        "5",
        "--driver",
        "cell_hands",
        "--out",
        str(tmp_path),
    ]
    monkeypatch.setattr(sys, "argv", ["hostile_wires", *arguments])

    main()

    found = json.loads((tmp_path / "hostile_wires.json").read_text())
    assert [one["driver"] for one in found["drivers"]] == ["cell_hands"]
    assert [one["inputs"] for one in found["codecs"]] == [50]
    assert [one["faults"] for one in found["links"]] == [5]
    assert "cell_hands" in capsys.readouterr().out
