"""Commands whose work is many parts: the same answer from one worker and from two, and again after a stop."""

import json

import pytest

from tests.helpers.archive import written_archive
from tests.helpers.commands import answer as truepose
from tests.helpers.exchange.rows import read_rows


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    return written_archive(tmp_path_factory.mktemp("archive"), readings=(2, 12))


def test_an_archive_is_computed_once_and_its_table_names_what_failed(archive, tmp_path):
    (archive / "broken.zip").write_bytes(b"none")
    out = tmp_path / "out"

    status, said, _ = truepose("reanalyse", archive, "--out", out, "--workers", "2")
    again, document, _ = truepose("reanalyse", archive, "--out", out, "--workers", "1", "--json")

    assert (status, again) == (1, 1)
    assert "broken.zip has no result" in said
    assert "3 campaigns: 2 computed, 0 already present, 1 failed." in said
    found = json.loads(document)
    assert (found["computed"], found["there_already"], list(found["failed"])) == (0, 2, ["broken.zip"])
    rows = read_rows(out / "changes.csv")
    assert [row["campaign"] for row in rows] == ["broken.zip", "campaign-1", "campaign-2"]
    assert rows[2]["status_now"] == "converged"


def test_draws_do_not_depend_on_who_makes_them(archive):
    asked = ("resample", archive / "campaign-2", "--effects", "base", "--draws", "60", "--seed", "3")

    one, two = (truepose(*asked, "--workers", count, "--json") for count in (1, 2))

    assert one == two
    status, document, _ = one
    assert status == 0
    found = json.loads(document)
    assert (found["draws"], found["by"], found["seed"]) == (60, "configurations", 3)
    assert all(row["standard_deviation"] > 0.0 for row in found["parameters"])


def test_the_best_of_several_plans_is_the_plan_of_its_seed():
    asked = ("plan", "abb-irb-120", "--n", "14", "--json")

    status, best, said = truepose(*asked, "--seed", "4", "--tries", "2", "--workers", "2")
    seed = int(said.split("seed ")[1].split()[0])
    alone = [json.loads(truepose(*asked, "--seed", number)[1]) for number in (4, 5)]

    assert status == 0
    assert json.loads(best) == alone[seed - 4]
    assert alone[seed - 4]["observability"]["O1"] == max(one["observability"]["O1"] for one in alone)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("reanalyse", "nowhere", "--out", "out"), "nowhere: there is no such folder or database."),
        (("resample", "docs/examples/campaign", "--workers", "many"), "--workers many: give a number"),
        (("resample", "docs/examples/campaign", "--effects", "none"), "none"),
    ],
)
def test_what_cannot_be_asked_is_a_sentence(arguments, sentence):
    status, _, said = truepose(*arguments)

    assert status == 2
    assert sentence in said


def test_a_server_that_is_away_is_no_unusable_input():
    status, _, said = truepose("verify", "postgres://ada:secret@127.0.0.1:1/shop")

    assert status == 3
    assert said.startswith("The server of postgresql://ada@127.0.0.1:1/shop does not respond")
    assert said.endswith("[TP-6010]\n")
    assert "secret" not in said
