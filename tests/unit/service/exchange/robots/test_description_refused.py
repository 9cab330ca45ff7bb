"""Every mistake in campaign.json is refused with line and key in one sentence."""

import json

import pytest

from tests.helpers.domain.builders import make_ballbar_campaign, make_campaign
from truepose.exchange.campaigns.folder import campaign_files, campaign_from
from truepose.exchange.errors import (
    BadValueError,
    MissingEntryError,
    MissingFileError,
    NewerVersionError,
    UnreadableFileError,
    WrongUnitError,
)
from truepose.messages.catalogue import english

REQUIRED = (
    "format",
    "robot",
    "dhm_nominal",
    "base_in_world_nominal",
    "tool_nests_mm",
    "tool_nest_u_mm",
    "masses",
    "gravity_m_s2_world",
    "robot_repeatability_mm",
    "files",
)


def read(edit, campaign=None):
    files = campaign_files(campaign or make_campaign())
    document = json.loads(files["campaign.json"])
    edit(document)
    return read_text(json.dumps(document, indent=1), files)


def read_text(text, files=None):
    files = {**(files or campaign_files(make_campaign())), "campaign.json": text}

    def load(name):
        if name not in files:
            raise MissingFileError("there is no such file", file=name)
        return files[name].encode()

    return campaign_from(load)


def steps_to(key):
    """The keys and places that lead to an entry: `tool_nests_mm[0]` to "tool_nests_mm" and 0."""
    return [
        int(step) if step.isdigit() else step for step in key.replace("[", ".").replace("]", "").split(".")
    ]


def put(key, value):
    def edit(document):
        *way, last = steps_to(key)
        for step in way:
            document = document[step]
        document[last] = value

    return edit


def rename(key, new):
    def edit(document):
        *way, last = steps_to(key)
        for step in way:
            document = document[step]
        document[new] = document.pop(last)

    return edit


def require_refused(edit, kind, key, sentence):
    with pytest.raises(kind) as refusal:
        read(edit)

    error = refusal.value
    assert (error.file, error.key or None) == ("campaign.json", key)
    assert error.line is not None
    assert sentence in str(error)
    assert str(error).endswith(".")


SKEW = {"covariance_mm_rad": [[1 + i for i in range(6)] for _ in range(6)]}
VALUES = {
    "format 0": ("format", 0, "must be 1"),
    "a robot without a name": ("robot", " ", "the text is empty"),
    "no joints": ("dhm_nominal", [], "the table has no rows"),
    "joints from 0": ("dhm_nominal[0].joint", 0, "joint 0 is in row 1"),
    "joints out of order": ("dhm_nominal[1].joint", 3, "joint 3 is in row 2"),
    "a sign of 0": ("dhm_nominal[1].sign", 0, "must be 1 or -1"),
    "a length that is text": ("dhm_nominal[1].a_mm", "50", "'50' is not a number"),
    "a length that is true": ("dhm_nominal[1].a_mm", True, "True is not a number"),
    "no nests": ("tool_nests_mm", [], "the list is empty"),
    "a nest in the plane": ("tool_nests_mm[0]", [1, 2], "2 entries found where 3"),
    "a negative uncertainty": ("tool_nest_u_mm", -0.1, "must lie between 0 and inf"),
    "a mass of a frame that is none": ("masses[0].frame", 4, "between 1 and 3"),
    "gear ratios of two joints of three": ("gear_ratio", [1, 2], "2 entries found where 3 are required"),
    "repeatability included, perhaps": ("u_includes_repeatability", "yes", "must be true or"),
    "a simulation that is perhaps one": ("simulated", "yes", "must be true or false"),
    "a day that there is not": (
        "measured_on",
        "2026-02-30",
        "'2026-02-30' is not a date; write it as YYYY-MM-DD, such as 2026-03-03",
    ),
    "a day by its week": ("measured_on", "2026-W10-2", "is not a date"),
    "files that are a list": ("files", [], "an object with keys is required"),
    "a file outside the folder": ("files.calibration", "../calibration.csv", "plain name"),
    "a file of another drive": ("files.calibration", "C:points.csv", "plain name"),
    "a number with 400 digits": ("robot_repeatability_mm", 10**400, "is not finite"),
}


@pytest.mark.parametrize("case", VALUES)
def test_a_value_that_cannot_be_is_refused_where_it_is(case):
    key, value, sentence = VALUES[case]

    require_refused(put(key, value), BadValueError, key, sentence)


WITHIN = {
    "a nest that faces nowhere": ("tool_nest_axis", [[0, 0, 2]], "[0]", "a unit vector is required"),
    "a compliance of 0": (
        "typical_compliance_rad_per_Nmm",
        [1e-8, 0, 1e-8],
        "[1]",
        "must be greater than 0",
    ),
    "a registration of 5 rows": (
        "world_registration",
        {"covariance_mm_rad": [[0] * 6] * 5},
        ".covariance_mm_rad",
        "5 entries found where 6",
    ),
    "a registration that is not symmetric": (
        "world_registration",
        SKEW,
        ".covariance_mm_rad",
        "must be symmetric",
    ),
    "a note that is no text": ("notes", [3], "[0]", "3 is not text"),
}


@pytest.mark.parametrize("case", WITHIN)
def test_a_mistake_within_a_value_is_refused_where_it_is(case):
    key, value, place, sentence = WITHIN[case]

    require_refused(put(key, value), BadValueError, key + place, sentence)


UNITS = {
    "a table in metres": ("dhm_nominal[2].a_mm", "a_m", "a_mm in mm is required"),
    "a table in radians": ("dhm_nominal[0].alpha_deg", "alpha_rad", "alpha_deg"),
    "a base in metres": ("base_in_world_nominal.x_mm", "x_m", "x_mm in mm"),
    "a mass in grams": ("masses[0].kg", "g", "kg in kg is required"),
    "gravity in the base": ("gravity_m_s2_world", "gravity_m_s2_base", "in the world frame"),
    "a repeatability in micrometres": (
        "robot_repeatability_mm",
        "robot_repeatability_um",
        "robot_repeatability_mm in mm is required",
    ),
}


@pytest.mark.parametrize("case", UNITS)
def test_another_unit_in_a_key_is_refused_with_the_one_that_is_required(case):
    key, other, sentence = UNITS[case]
    place = key.rpartition(".")[0]

    require_refused(rename(key, other), WrongUnitError, f"{place}.{other}" if place else other, sentence)


OF_ANOTHER_KIND = {
    "gravity in other units": ("gravity_m_s2_world", [0, 0, -9810], WrongUnitError, "in m/s2"),
    "a later format": ("format", 2, NewerVersionError, "has format 2"),
    "a file that is not there": (
        "files.calibration",
        "points.csv",
        MissingFileError,
        "points.csv is not in",
    ),
    "no readings": ("files", {}, MissingEntryError, "no readings are named"),
}


@pytest.mark.parametrize("case", OF_ANOTHER_KIND)
def test_a_value_that_tells_of_another_mistake_is_refused_as_that(case):
    key, value, kind, sentence = OF_ANOTHER_KIND[case]

    require_refused(put(key, value), kind, key, sentence)


def test_what_is_missing_inside_is_named_with_its_place():
    def without_d(document):
        del document["dhm_nominal"][1]["d_mm"]

    require_refused(without_d, MissingEntryError, "dhm_nominal[1]", "key d_mm is missing")


def test_certified_nests_need_their_uncertainty():
    nests = {"fixed_nests_certified_mm": [[0, 0, 0]]}
    unknown = nests | {"fixed_nest_u_mm": None}

    require_refused(lambda d: d.update(nests), MissingEntryError, None, "fixed_nest_u_mm is missing")
    require_refused(lambda d: d.update(unknown), BadValueError, "fixed_nest_u_mm", "cannot be null")


@pytest.mark.parametrize("key", REQUIRED)
def test_a_missing_required_key_is_named(key):
    with pytest.raises(
        MissingEntryError, match=f"campaign.json, line 1: key {key} is missing; it is required"
    ):
        read(lambda document: document.pop(key))


def test_the_line_is_that_of_the_value():
    text = '{\n "format": 1,\n "robot": "x",\n "dhm_nominal": [\n  {"joint": 1},\n  {"joint": 1}\n ]\n}'

    with pytest.raises(MissingEntryError) as refusal:
        read_text(text)

    assert refusal.value.line == 5  # the first row lacks alpha_deg


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "the text ends too early"),
        ('{"format": 1, "robot": ', "the text ends too early"),
        ("format: 1", "not a complete JSON document"),
        ('{"format": 1, "format": 1}', "key format appears twice"),
        ('{"format": NaN}', "NaN is not a finite number"),
        ('{"format": 1' + "0" * 5000 + "}", "not a usable JSON document"),
        ("[" * 100_000, "not a usable JSON document"),
    ],
    ids=["empty", "cut off", "another language", "key twice", "NaN", "endless number", "endless nesting"],
)
def test_what_is_no_json_is_refused(text, sentence):
    with pytest.raises(UnreadableFileError, match=sentence) as refusal:
        read_text(text)

    assert refusal.value.file == "campaign.json"


def test_a_list_instead_of_an_object_is_refused():
    with pytest.raises(BadValueError, match="an object with keys is required"):
        read_text("[1]")


def test_a_setup_needs_its_uncertainty():
    with pytest.raises(MissingEntryError, match="setup_u_mm is missing"):
        read(lambda document: document.pop("setup_u_mm"), make_ballbar_campaign())


def test_unknown_keys_are_reported_once_by_name():
    def edit(document):
        document["operator"] = "Ann"
        document["files"]["photos"] = "photos.zip"
        for row in document["dhm_nominal"]:
            row["brake"] = True

    campaign = read(edit)

    assert tuple(map(english, campaign.ignored)) == (
        "campaign.json: key operator is not part of the format and is ignored.",
        "campaign.json: key brake in dhm_nominal is not part of the format and is ignored.",
        "campaign.json: role photos under files is not part of the format and is ignored.",
    )
