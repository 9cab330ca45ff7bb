"""`--set-aside` of `identify` and `diagnose`: what is left out, how it is said, and what is refused."""

import csv
import getpass
import json

import pytest

from tests.helpers.checkout import CHECKOUT
from tests.helpers.commands import assert_one_sentence, installed, typed
from truepose.cli.set_aside import without_set_aside
from truepose.domain.campaign import ReadingName, ReadingsSetAside
from truepose.domain.errors import ConfigurationError
from truepose.domain.set_aside import found_in, without_readings
from truepose.exchange.campaigns.folder import read_campaign
from truepose.exchange.results.identification import identification_document
from truepose.identification import identify
from truepose.storage.documents import to_document

CAMPAIGN = CHECKOUT / "docs/examples/campaign"
SAID = "2 readings set aside by Ada Byron: bumped the tripod; door slammed."
ASIDE = ("--set-aside", "17=bumped the tripod", "--set-aside", "5/1=door slammed", "--person", "Ada Byron")
PAINTED_ELSEWHERE = pytest.mark.usefixtures("empty_pictures")


def as_the_service_does(*names, reason="it slipped"):
    whole = read_campaign(CAMPAIGN)
    return without_readings(whole, found_in(whole, ReadingsSetAside(names, reason, "Ada Byron")))


def documents(done):
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_an_identification_is_that_of_the_service_without_the_same_readings():
    aside = ("--set-aside", "17=it slipped", "--set-aside", "5=it slipped", "--person", "Ada Byron")
    campaign = as_the_service_does(ReadingName(17, 1), ReadingName(5, 1))

    found = documents(typed("identify", CAMPAIGN, *aside, "--json"))

    assert found == identification_document(identify(campaign), campaign.robot.name)
    assert found["set_aside"]["rows"] == [4, 16]


class EnoughError(ConfigurationError):
    """A diagnosis takes ten seconds: it ends once the campaign is known that it would be made of."""


@pytest.fixture
def diagnosed(monkeypatch):
    """The campaigns that are handed to the diagnosis."""
    handed = []

    def diagnose(campaign, *_):
        handed.append(campaign)
        raise EnoughError

    monkeypatch.setattr("truepose.diagnosis.diagnose.diagnose", diagnose)
    return handed


def test_a_diagnosis_is_made_of_the_campaign_that_the_service_hands_it(diagnosed):
    typed("diagnose", CAMPAIGN, "--set-aside", "17=it slipped", "--person", "Ada Byron")

    assert to_document(diagnosed) == to_document([as_the_service_does(ReadingName(17, 1))])


def test_without_the_option_nothing_differs_by_a_bit(diagnosed):
    whole = read_campaign(CAMPAIGN)

    found = documents(typed("identify", CAMPAIGN, "--json"))
    typed("diagnose", CAMPAIGN)

    assert found == identification_document(identify(whole), whole.robot.name)
    assert found["set_aside"] is None
    assert to_document(diagnosed) == to_document([whole])
    assert without_set_aside(whole, None, None, "") is whole


def test_each_reading_keeps_its_reason_in_the_document():
    told = documents(typed("identify", CAMPAIGN, *ASIDE, "--json"))["set_aside"]

    assert [(one["config"], one["nest"]) for one in told["readings"]] == [(17, 1), (5, 1)]
    assert told["reasons"] == ["bumped the tripod", "door slammed"]
    assert (told["reason"], told["person"]) == ("bumped the tripod; door slammed", "Ada Byron")


@PAINTED_ELSEWHERE
@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_terminal_report_and_model_say_how_many_and_why(command, tmp_path):
    report, model = tmp_path / "report.html", tmp_path / "model.json"

    done = typed(command, CAMPAIGN, *ASIDE, "--report", report, "--model-out", model)

    listed = "configuration 17, nest 1 (bumped the tripod); configuration 5, nest 1 (door slammed)"
    assert done.returncode == 0, done.stderr
    assert SAID in " ".join(done.stdout.split())
    assert f"Set aside: {listed}.\n" in done.stdout
    assert f"{SAID} {listed}" in report.read_text()
    assert json.loads(model.read_text())["identified_from"]["readings_set_aside"] == 2


def test_the_campaign_stays_as_it_was():
    before = {path.name: path.read_bytes() for path in CAMPAIGN.iterdir()}

    assert typed("identify", CAMPAIGN, *ASIDE).returncode == 0
    assert {path.name: path.read_bytes() for path in CAMPAIGN.iterdir()} == before


def test_a_file_names_many(tmp_path):
    file = tmp_path / "aside.csv"
    file.write_text("config,nest,reason\n17,1,bumped the tripod\n5,,door slammed\n")
    one_by_one = typed("identify", CAMPAIGN, *ASIDE, "--json")

    by_file = typed("identify", CAMPAIGN, "--set-aside-file", file, "--person", "Ada Byron", "--json")

    assert documents(by_file) == documents(one_by_one)


def test_whoever_is_not_named_is_the_account(monkeypatch):
    monkeypatch.setattr(getpass, "getuser", lambda: "ada")

    found = without_set_aside(read_campaign(CAMPAIGN), ["17=it slipped"], None, "")

    assert found.set_aside.person == "ada"


def test_an_account_without_a_name_is_asked_for_one(monkeypatch):
    def nameless():
        raise KeyError("getpwuid(): uid not found: 1000")

    monkeypatch.setattr(getpass, "getuser", nameless)

    with pytest.raises(ConfigurationError, match="say with --person who"):
        without_set_aside(read_campaign(CAMPAIGN), ["17=it slipped"], None, "")


@pytest.mark.parametrize("command", ["identify", "diagnose"])
@pytest.mark.parametrize(
    ("aside", "why"),
    [
        (["99=x"], "no reading of configuration 99 to identify from; the nearest is configuration 30"),
        (["17/2=x"], "no reading of 17/2"),
        (["17"], "a reason of 1 to 500 characters is required"),
        (["tripod=x"], "name the reading by the numbers"),
        (["101=x"], "judges the model and cannot be set aside"),
        (["17=x", "17/1=y"], "configuration 17, nest 1 is set aside twice"),
        ([f"{number}=x" for number in range(1, 8)], "7 of 30 readings are more than 20%"),
        ([f"{number}=x" for number in range(1, 31)], "30 of 30 readings are more than 20%"),
    ],
)
def test_what_cannot_be_set_aside_is_one_sentence(command, aside, why):
    options = [part for one in aside for part in ("--set-aside", one)]

    assert_one_sentence(typed(command, CAMPAIGN, *options, "--person", "Ada Byron"), why)


def test_of_several_readings_of_a_configuration_one_is_to_be_named(tmp_path):
    campaign = with_two_nests(tmp_path / "campaign")

    refused = installed("identify", campaign, "--set-aside", "17=it slipped")

    assert_one_sentence(refused, "Configuration 17 has 2 readings: name one of them, 17/1, 17/2.")


def with_two_nests(folder):
    """The example with a second reading of each configuration; what it says does not matter."""
    folder.mkdir()
    for path in CAMPAIGN.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    rows = list(csv.DictReader((CAMPAIGN / "calibration.csv").read_text().splitlines()))
    with (folder / "calibration.csv").open("w", newline="") as file:
        table = csv.DictWriter(file, rows[0])
        table.writeheader()
        table.writerows(row | {"nest": nest} for row in rows for nest in (1, 2))
    return folder


@pytest.mark.parametrize("option", [("--set-aside", "101=it slipped"), ("--set-aside-file", "aside.csv")])
def test_a_validation_sets_nothing_aside(option, tmp_path):
    model = tmp_path / "model.json"
    assert typed("identify", CAMPAIGN, "--model-out", model).returncode == 0

    refused = typed("validate", model, CAMPAIGN / "validation.csv", *option)

    assert_one_sentence(refused, "Readings that judge a model cannot be set aside", "truepose identify")
