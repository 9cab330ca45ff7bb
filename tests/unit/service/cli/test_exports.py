"""`truepose export`, as a user types it: a file, sentences or one document, and an exit status."""

import json

import pytest

import truepose as tp
from tests.helpers.commands import answer
from tests.helpers.identification.models import ROBOTS, extended, model_of, registered
from tests.helpers.identification.zones import zoned
from truepose.exchange.models.file import write_model

PRINTED = {"as", "robot", "remarks", "nominal_error", "error"}
OF_TABLES = {"fitted", "left_out"}
OF_CONTROLLERS = {
    "model_error", "joint_zeros_deg", "base_in_world", "world_in_base", "tool_points", "tool_frame"
}  # fmt: skip


@pytest.fixture
def model(tmp_path):
    write_model(registered(zoned(extended(ROBOTS["irb120"], "backlash"))), tmp_path / "robot.json")
    return tmp_path / "robot.json"


def typed(*arguments):
    return answer("export", *arguments)


@pytest.mark.parametrize(
    ("form", "keys"), [("urdf", OF_TABLES), ("dhm", OF_TABLES), ("controller", OF_CONTROLLERS)]
)
def test_a_document_has_the_promised_keys(model, tmp_path, form, keys):
    status, printed, said = typed(model, "--as", form, "--out", tmp_path / "out.txt", "--json")

    document = json.loads(printed)
    assert (status, said) == (0, "")
    assert set(document) == PRINTED | keys
    assert (document["as"], document["robot"]) == (form, "ABB IRB 120")
    assert document["error"]["mean_mm"] > 0.0


def test_what_is_lost_is_said_and_the_file_is_there(model, tmp_path):
    status, printed, _ = typed(model, "--as", "urdf", "--out", tmp_path / "robot.urdf")

    assert status == 0
    assert "Not in the file: backlash (parameters: 3)." in printed.splitlines()
    assert (tmp_path / "robot.urdf").read_text().startswith("<?xml")


def test_sentences_come_in_french_where_that_is_asked_for(model, tmp_path):
    _, printed, _ = typed(model, "--as", "urdf", "--out", tmp_path / "robot.urdf", "--language", "fr")

    assert "Pas dans le fichier" in printed
    assert "Not in the file: " in (tmp_path / "robot.urdf").read_text()


def test_a_fitted_table_is_nearer_to_the_model(model, tmp_path):
    plain, fitted = (
        json.loads(typed(model, "--as", "dhm", "--out", tmp_path / "t.csv", "--json", *more)[1])
        for more in ((), ("--fitted",))
    )

    assert fitted["error"]["mean_mm"] < plain["error"]["mean_mm"]
    assert (plain["fitted"], fitted["fitted"]) == (False, True)
    assert (tmp_path / "t.csv").read_text().startswith("joint,sign,alpha_deg,u_alpha_deg,nominal_alpha_deg")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--as", "ros"), "ABB IRB 120 does not have the axes of a Universal Robots arm"),
        (("--as", "urdf", "--out", "nowhere/robot.urdf"), "the folder nowhere does not exist"),
    ],
)
def test_what_cannot_be_written_is_one_sentence(model, tmp_path, arguments, words):
    status, printed, said = typed(model, "--out", tmp_path / "out", *arguments)

    assert (status, printed) == (2, "")
    assert words in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("arguments", [("--as", "controller"), ("--as", "urdf", "--fitted")])
def test_a_model_that_does_not_know_its_zone_is_refused(tmp_path, arguments):
    write_model(registered(model_of(ROBOTS["irb120"])), tmp_path / "old.json")

    status, _, said = typed(tmp_path / "old.json", "--out", tmp_path / "out", *arguments)

    assert status == 2
    assert "measured zone" in said


def test_a_notebook_writes_the_same_file(model, tmp_path):
    typed(model, "--as", "controller", "--out", tmp_path / "typed.txt")

    remarks = tp.export(model, "controller", tmp_path / "called.txt")

    assert (tmp_path / "typed.txt").read_text() == (tmp_path / "called.txt").read_text()
    assert remarks[0].startswith("Over the measured zone, the nominal robot (base and unknown nests ")


def test_a_format_that_is_none_is_refused_with_those_that_are(model, tmp_path):
    with pytest.raises(tp.TrueposeError, match="'sdf' is not a model format; the formats are urdf, ros, dhm"):
        tp.export(model, "sdf", tmp_path / "robot.sdf")
