"""What the workflows promise: every system, every Python that is taken, commands that are there."""

import re
import tomllib

import pytest
import yaml

from tests.helpers.checkout import CHECKOUT

FOLDER = CHECKOUT / ".github" / "workflows"
SYSTEMS = {"ubuntu-latest", "macos-latest", "windows-latest"}
PYTHONS = ["3.11", "3.12", "3.13", "3.14"]


def workflow(name):
    return yaml.safe_load((FOLDER / name).read_text(encoding="utf-8"))


def jobs(name="tests.yml"):
    return workflow(name)["jobs"]


def systems(job):
    matrix = job.get("strategy", {}).get("matrix", {})
    return set(matrix.get("os", [job["runs-on"]]))


def commands(job):
    return [step["run"] for step in job["steps"] if "run" in step]


@pytest.mark.parametrize("file", sorted(file.name for file in FOLDER.glob("*.yml")))
def test_a_workflow_reads_the_repository_only_and_each_job_ends_by_itself(file):
    found = workflow(file)

    assert found["permissions"] == {"contents": "read"}
    for job in found["jobs"].values():
        assert job["timeout-minutes"] <= 90
        assert job["steps"]


@pytest.mark.parametrize("file", sorted(file.name for file in FOLDER.glob("*.yml")))
def test_every_target_of_make_that_a_workflow_names_is_there(file):
    targets = set(re.findall(r"^([a-z-]+):", (CHECKOUT / "Makefile").read_text(encoding="utf-8"), re.M))
    named = [
        name
        for job in jobs(file).values()
        for command in commands(job)
        for name in re.findall(r"\bmake ([a-z-]+)", command)
    ]

    assert set(named) <= targets


def test_the_demo_of_the_wheel_runs_on_every_system_with_every_python():
    job = jobs()["installed"]

    assert systems(job) == SYSTEMS
    assert job["strategy"]["matrix"]["python"] == PYTHONS
    assert any("truepose demo" in command for command in commands(job))


def test_every_system_runs_tests_with_every_python():
    running = [job for job in jobs().values() if any("test" in command for command in commands(job))]

    assert set().union(*map(systems, running)) == SYSTEMS
    assert [job["strategy"]["matrix"]["python"] for job in running] == [PYTHONS] * len(running)


def test_where_there_is_no_make_none_is_called():
    on_windows = [job for job in jobs().values() if "windows-latest" in systems(job)]

    assert on_windows
    assert not [command for job in on_windows for command in commands(job) if re.search(r"\bmake ", command)]


def test_what_windows_tests_is_in_the_checkout():
    (command,) = (command for command in commands(jobs()["windows"]) if "pytest" in command)
    places = [word for word in command.split() if word.startswith("tests/")]

    assert places
    assert [place for place in places if not (CHECKOUT / place).is_dir()] == []


def test_the_oldest_python_is_the_one_that_the_package_asks_for():
    asked = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert asked["requires-python"] == f">={PYTHONS[0]}"
