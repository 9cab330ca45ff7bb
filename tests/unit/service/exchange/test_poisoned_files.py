"""Whatever a stranger brings is read, or refused in one sentence, in a time and a memory of its own size."""

import functools
import io
import json
import random
import time
import tracemalloc
import zipfile
from importlib.resources import files
from pathlib import Path

import pytest

from tests.helpers.domain.builders import (
    make_ballbar_campaign,
    make_campaign,
    make_contact_campaign,
    make_model,
)
from tests.helpers.exchange.archives import zipped
from tests.helpers.exchange.poisons import poisoned
from tests.helpers.exchange.robot_programs import PROGRAMS, read
from tests.helpers.exchange.workbooks import workbook
from tests.unit.service.exchange.import_wizard.tables import plain
from tests.unit.service.exchange.robots.test_ros_calibrated_kinematics import PUBLISHED, text_of
from tests.unit.service.exchange.robots.test_urdf_in import BENT
from tests.unit.service.exchange.test_ballbar_result import RESULT
from truepose.exchange.ballbar_result import ballbar_result_from_bytes
from truepose.exchange.campaigns.folder import campaign_files, campaign_from
from truepose.exchange.campaigns.point_list import read_point_list
from truepose.exchange.campaigns.points_with_joints import Stated, import_points
from truepose.exchange.campaigns.zip_file import read_campaign_zip
from truepose.exchange.cells.file import read_cell
from truepose.exchange.cells.volumes import read_keep_out_file
from truepose.exchange.errors import InputFileError, MissingFileError
from truepose.exchange.import_wizard import robots
from truepose.exchange.import_wizard.dialogue import Choices
from truepose.exchange.import_wizard.reading import read_imported_files
from truepose.exchange.models.file import model_file_from_text, model_text
from truepose.exchange.robots.named import read_robot_file
from truepose.exchange.robots.ros_calibrated_kinematics import kinematics_from_text
from truepose.exchange.robots.urdf_import import urdf_from_text
from truepose.exchange.tables.files import held_out_readings, points_to_predict, visits_from
from truepose.exchange.tables.targets import targets_of
from truepose.identification.verdict.robot_match import Match

DRAWS = 8  # of each kind of file; `make thorough` draws more
BASE_S, PER_BYTE_S = 0.5, 20e-6
BASE_BYTES, PER_BYTE = 8e6, 400.0
LONGEST_SENTENCE = 1500  # with the place
JOINTS = ",".join(f"q{k}_deg" for k in range(1, 7))
CHOICES = Choices(robot="abb-irb-120", u_mm=0.02, undated=True)


def folder(load, given):
    def loaded(name):
        if name not in given:
            raise MissingFileError("there is no such file", file=name)
        return given[name]

    return load(loaded)


stored = functools.partial(zipped, method=zipfile.ZIP_STORED)


def parts_of(book):
    with zipfile.ZipFile(io.BytesIO(book)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def on_disk(read_it, given, where):
    for name, data in given.items():
        (where / name).write_bytes(data)
    return read_it(where)


def joined(where):
    stated = Stated("abb-irb-120", unit="mm", u_mm=0.02)
    return import_points(where / "points.txt", where / "joints.csv", stated)


def of_campaign(campaign):
    return {name: text.encode() for name, text in campaign_files(campaign).items()}


MODEL = json.loads(model_text(make_model()))
TARGETS = f"target,x_mm,y_mm,z_mm,qw,qx,qy,qz,branch,{JOINTS}\na,300,0,400,1,0,0,0,,0,10,20,30,40,50\n"
POINTS = f"config,nest,{JOINTS},x_mm,y_mm,z_mm,u_mm\n1,1,0,10,20,30,40,50,300,0,400,0.02\n"
BOOK = parts_of(workbook({"S": [row.split(",") for row in plain(3).decode().splitlines()]}))
READERS = {
    "campaign": (of_campaign(make_campaign()), lambda given, _: folder(campaign_from, given)),
    "legs": (of_campaign(make_ballbar_campaign()), lambda given, _: folder(campaign_from, given)),
    "contacts": (of_campaign(make_contact_campaign()), lambda given, _: folder(campaign_from, given)),
    "zip": (
        of_campaign(make_campaign()),
        lambda given, _: read_campaign_zip(stored(given.items())),
    ),
    "model": (
        {"a.json": json.dumps(MODEL, indent=1).encode()},
        lambda given, _: model_file_from_text(given["a.json"], "a.json", accept_edited=True),
    ),
    **{
        name: ({name: data}, lambda given, _, name=name: read(name, given[name]))
        for name, data in PROGRAMS.items()
    },
    "targets": (
        {"t.csv": TARGETS.encode()},
        lambda given, _: list(targets_of("t.csv", given["t.csv"], 6, (1,))),
    ),
    "points": (
        {"t.csv": POINTS.encode()},
        lambda given, _: points_to_predict("t.csv", given["t.csv"], 6, (1,)),
    ),
    "held out": (
        {"t.csv": POINTS.encode()},
        lambda given, _: held_out_readings("t.csv", given["t.csv"], 6, (1,)),
    ),
    "visits": (
        {"v.csv": b"campaign,robot,instrument,day\na,1,2,2026-03-03\n"},
        lambda given, _: visits_from("v.csv", given["v.csv"]),
    ),
    "list": (
        {"p.txt": b"// Units: Millimeters\nA G P1 1.5 -2 3\nA G P2 4 5 6.25\n"},
        lambda given, _: read_point_list("p.txt", given["p.txt"]),
    ),
    "joined": (
        {
            "points.txt": b"P1 1.5 -2 3\nP2 4 5 6.25\n",
            "joints.csv": f"config,nest,{JOINTS}\n1,1,0,1,2,3,4,5\n2,2,1,2,3,4,5,6\n".encode(),
        },
        functools.partial(on_disk, joined),
    ),
    "table": ({"a.csv": plain(3)}, lambda given, _: read_imported_files(given, CHOICES)),
    "workbook": (BOOK, lambda given, _: read_imported_files({"a.xlsx": stored(given.items())}, CHOICES)),
    "archive": (
        of_campaign(make_campaign()),
        lambda given, _: read_imported_files({"a.zip": stored(given.items())}, Choices(undated=True)),
    ),
    "urdf": ({"a.urdf": BENT.encode()}, lambda given, _: urdf_from_text("a.urdf", given["a.urdf"])),
    "ros": (
        {"a.yaml": text_of(PUBLISHED).encode()},
        lambda given, _: kinematics_from_text("a.yaml", given["a.yaml"]),
    ),
    "robot": (
        {"a.toml": (files("truepose.exchange") / "robots" / "abb-irb-120.toml").read_bytes()},
        functools.partial(on_disk, lambda where: read_robot_file(where / "a.toml")),
    ),
    "cell": (
        {"a.toml": Path("docs/examples/real-cell.toml").read_bytes()},
        functools.partial(on_disk, lambda where: read_cell(where / "a.toml")),
    ),
    "keep-out": (
        {"a.toml": Path("docs/examples/keep-out.toml").read_bytes()},
        functools.partial(on_disk, lambda where: read_keep_out_file(where / "a.toml")),
    ),
    "result": (
        {"a.b5r": RESULT.encode()},
        lambda given, _: ballbar_result_from_bytes(given["a.b5r"], "a.b5r"),
    ),
}


@pytest.fixture(autouse=True)
def nothing_is_fitted(monkeypatch):
    """Which robot fits is computed and not read; what it takes does not grow with the file."""
    monkeypatch.setattr(robots, "matches", lambda known, *_: tuple(Match(robot, (), 0.0) for robot in known))


@pytest.mark.parametrize("kind", READERS)
def test_a_sound_file_is_read(kind, tmp_path):
    given, read_it = READERS[kind]

    found = read_it(given, tmp_path)

    assert found is not None
    assert getattr(getattr(found, "understood", None), "fault", None) is None


@pytest.mark.parametrize("kind", READERS)
def test_a_poisoned_file_is_read_or_refused_in_its_own_time_and_memory(kind, tmp_path):
    for seed in range(DRAWS):
        require_answer(kind, seed, tmp_path)


def require_answer(kind, seed, where):
    given, read_it = READERS[kind]
    draw = random.Random(f"{kind} {seed}")
    chosen = draw.choice([*given])
    brought = {**given, chosen: poisoned(given[chosen], draw)}
    size = sum(map(len, brought.values()))
    place = f"{kind} {seed}: {chosen}"
    began = time.process_time()
    _read_or_refused(place, lambda: read_it(brought, where))
    took_s = time.process_time() - began
    # Once more: what is traced takes many times as long.
    tracemalloc.start(1)
    _read_or_refused(place, lambda: read_it(brought, where))
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert took_s <= BASE_S + PER_BYTE_S * size, (place, took_s)
    assert most <= BASE_BYTES + PER_BYTE * size, (place, most)


def _read_or_refused(place, read_once):
    try:
        read_once()
    except InputFileError as refused:
        assert "\n" not in str(refused), place
        assert len(str(refused)) <= LONGEST_SENTENCE, place
    except Exception as error:
        raise AssertionError(place) from error
