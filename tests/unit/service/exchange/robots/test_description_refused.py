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


def put(*path, value):
    def edit(document):
        for step in path[:-1]:
            document = document[step]
        document[path[-1]] = value

    return edit


def rename(old, new, *path):
    def edit(document):
        for step in path:
            document = document[step]
        document[new] = document.pop(old)

    return edit


REFUSED = {
    "a later format": (put("format", value=2), NewerVersionError, "format", "has format 2"),
    "format 0": (put("format", value=0), BadValueError, "format", "must be 1"),
    "a robot without a name": (put("robot", value=" "), BadValueError, "robot", "the text is empty"),
    "no joints": (put("dhm_nominal", value=[]), BadValueError, "dhm_nominal", "the table has no rows"),
    "joints from 0": (
        put("dhm_nominal", 0, "joint", value=0),
        BadValueError,
        "dhm_nominal[0].joint",
        "joint 0 stands in row 1",
    ),
    "joints out of order": (
        put("dhm_nominal", 1, "joint", value=3),
        BadValueError,
        "dhm_nominal[1].joint",
        "joint 3 stands in row 2",
    ),
    "a sign of 0": (
        put("dhm_nominal", 1, "sign", value=0),
        BadValueError,
        "dhm_nominal[1].sign",
        "must be 1 or -1",
    ),
    "a table in metres": (
        rename("a_mm", "a_m", "dhm_nominal", 2),
        WrongUnitError,
        "dhm_nominal[2].a_m",
        "a_mm in mm is required",
    ),
    "a table in radians": (
        rename("alpha_deg", "alpha_rad", "dhm_nominal", 0),
        WrongUnitError,
        "dhm_nominal[0].alpha_rad",
        "alpha_deg",
    ),
    "a row without d": (
        lambda d: d["dhm_nominal"][1].pop("d_mm"),
        MissingEntryError,
        "dhm_nominal[1]",
        "key d_mm is missing",
    ),
    "a length that is text": (
        put("dhm_nominal", 1, "a_mm", value="50"),
        BadValueError,
        "dhm_nominal[1].a_mm",
        "'50' is not a number",
    ),
    "a length that is true": (
        put("dhm_nominal", 1, "a_mm", value=True),
        BadValueError,
        "dhm_nominal[1].a_mm",
        "True is not a number",
    ),
    "a base in metres": (
        rename("x_mm", "x_m", "base_in_world_nominal"),
        WrongUnitError,
        "base_in_world_nominal.x_m",
        "x_mm in mm",
    ),
    "no nests": (put("tool_nests_mm", value=[]), BadValueError, "tool_nests_mm", "the list is empty"),
    "a nest in the plane": (
        put("tool_nests_mm", 0, value=[1, 2]),
        BadValueError,
        "tool_nests_mm[0]",
        "2 entries stand where 3",
    ),
    "a negative uncertainty": (
        put("tool_nest_u_mm", value=-0.1),
        BadValueError,
        "tool_nest_u_mm",
        "must lie between 0 and inf",
    ),
    "a nest that faces nowhere": (
        put("tool_nest_axis", value=[[0, 0, 2]]),
        BadValueError,
        "tool_nest_axis[0]",
        "a unit vector is required",
    ),
    "a mass of a frame that is none": (
        put("masses", 0, "frame", value=4),
        BadValueError,
        "masses[0].frame",
        "between 1 and 3",
    ),
    "a mass in grams": (
        rename("kg", "g", "masses", 0),
        WrongUnitError,
        "masses[0].g",
        "kg in kg is required",
    ),
    "gravity in the base": (
        rename("gravity_m_s2_world", "gravity_m_s2_base"),
        WrongUnitError,
        "gravity_m_s2_base",
        "in the world frame",
    ),
    "gravity in mm/s2": (
        put("gravity_m_s2_world", value=[0, 0, -9810]),
        WrongUnitError,
        "gravity_m_s2_world",
        "in m/s2",
    ),
    "gear ratios of two joints of three": (
        put("gear_ratio", value=[1, 2]),
        BadValueError,
        "gear_ratio",
        "2 entries stand where 3 are required",
    ),
    "a compliance of 0": (
        put("typical_compliance_rad_per_Nmm", value=[1e-8, 0, 1e-8]),
        BadValueError,
        "typical_compliance_rad_per_Nmm[1]",
        "must be greater than 0",
    ),
    "a repeatability in micrometres": (
        rename("robot_repeatability_mm", "robot_repeatability_um"),
        WrongUnitError,
        "robot_repeatability_um",
        "robot_repeatability_mm in mm is required",
    ),
    "repeatability included, perhaps": (
        put("u_includes_repeatability", value="yes"),
        BadValueError,
        "u_includes_repeatability",
        "neither true nor",
    ),
    "certified nests without uncertainty": (
        put("fixed_nests_certified_mm", value=[[0, 0, 0]]),
        MissingEntryError,
        None,
        "fixed_nest_u_mm is missing",
    ),
    "a certified nest of unknown uncertainty": (
        lambda d: d.update(fixed_nests_certified_mm=[[0, 0, 0]], fixed_nest_u_mm=None),
        BadValueError,
        "fixed_nest_u_mm",
        "null is not one",
    ),
    "a registration of 5 rows": (
        put("world_registration", value={"covariance_mm_rad": [[0] * 6] * 5}),
        BadValueError,
        "world_registration.covariance_mm_rad",
        "5 entries stand where 6",
    ),
    "a registration that is not symmetric": (
        put("world_registration", value={"covariance_mm_rad": [[1 + i for i in range(6)] for _ in range(6)]}),
        BadValueError,
        "world_registration.covariance_mm_rad",
        "must be symmetric",
    ),
    "a note that is no text": (put("notes", value=[3]), BadValueError, "notes[0]", "3 is not text"),
    "a simulation that is perhaps one": (
        put("simulated", value="yes"),
        BadValueError,
        "simulated",
        "neither true nor false",
    ),
    "a day that there is not": (
        put("measured_on", value="2026-02-30"),
        BadValueError,
        "measured_on",
        "'2026-02-30' is no day; one as 2026-03-03 is required",
    ),
    "a day by its week": (put("measured_on", value="2026-W10-2"), BadValueError, "measured_on", "is no day"),
    "files that are a list": (
        put("files", value=[]),
        BadValueError,
        "files",
        "an object with keys is required",
    ),
    "no readings": (put("files", value={}), MissingEntryError, "files", "no readings are named"),
    "a file that is not there": (
        put("files", "calibration", value="points.csv"),
        MissingFileError,
        "files.calibration",
        "points.csv is not in",
    ),
    "a file outside the folder": (
        put("files", "calibration", value="../calibration.csv"),
        BadValueError,
        "files.calibration",
        "plain name",
    ),
    "a file of another drive": (
        put("files", "calibration", value="C:points.csv"),
        BadValueError,
        "files.calibration",
        "plain name",
    ),
    "a number with 400 digits": (
        put("robot_repeatability_mm", value=10**400),
        BadValueError,
        "robot_repeatability_mm",
        "is not finite",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_mistake_in_the_description_is_refused_where_it_is(case):
    edit, kind, key, sentence = REFUSED[case]

    with pytest.raises(kind) as refusal:
        read(edit)

    error = refusal.value
    assert (error.file, error.key or None) == ("campaign.json", key)
    assert error.line is not None
    assert sentence in str(error)
    assert str(error).endswith(".")


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
        "campaign.json: key brake of dhm_nominal is not part of the format and is ignored.",
        "campaign.json: role photos of files is not part of the format and is ignored.",
    )
