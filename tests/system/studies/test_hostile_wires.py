"""The study of hostile input to the drivers runs, and its models tell right from wrong."""

import json
import sys

import pytest

from tests.studies.hostile_wires import BENCHES, main, study
from tests.studies.wires.spoiling import GENERAL


@pytest.mark.parametrize("name", BENCHES)
async def test_no_driver_takes_a_wrong_value_that_something_betrays(name):
    (tally,) = await study(300, 7, (name,))

    assert (tally.foreign, tally.hung, tally.wrong_betrayable) == (0, 0, 0), tally.examples
    assert tally.inputs == 300
    assert tally.right > 150  # the good wire behind each fault
    assert tally.refused > 30


async def test_the_same_seed_gives_the_same_study():
    first, second = [await study(50, 11, ("abb_open_abb",)) for _ in range(2)]

    assert (first[0].right, first[0].refused) == (second[0].right, second[0].refused)


@pytest.mark.parametrize("name", BENCHES)
async def test_a_model_knows_a_wrong_value(name):
    bench = BENCHES[name]()

    assert not bench.is_right(1234.5)


def test_every_fault_says_what_it_is():
    assert all(spoil.__doc__ for spoil in GENERAL)


def test_the_study_writes_what_it_found(tmp_path, monkeypatch, capsys):
    arguments = ["--runs", "20", "--driver", "cell_hands", "--out", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", ["hostile_wires", *arguments])

    main()

    found = json.loads((tmp_path / "hostile_wires.json").read_text())
    assert [one["driver"] for one in found["drivers"]] == ["cell_hands"]
    assert "cell_hands" in capsys.readouterr().out
