"""What somebody installs: source archive, wheel, clean environment; from there a notebook.

The demo of what was installed is in `tests/thorough/system/demo`.
"""

import shutil
import subprocess
import sys
import tarfile
import zipfile

import pytest

from tests.helpers.checkout import CHECKOUT
from tests.integration.documentation.test_notebook_page import promised
from tests.thorough.integration.deployment.images import environment, install_wheel
from truepose.version import __version__

_PACKAGES = {"truepose", "truepose_drivers", "truepose_simulators"}


def _built(target, source, folder):
    command = [sys.executable, "-m", "hatchling", "build", "--target", target, "--directory", str(folder)]
    subprocess.run(command, cwd=source, check=True, capture_output=True, timeout=120)
    (built,) = folder.glob("truepose-*")
    return built


def _names(wheel):
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    """The source archive of this checkout, unpacked."""
    folder = tmp_path_factory.mktemp("archive")
    with tarfile.open(_built("sdist", CHECKOUT, tmp_path_factory.mktemp("sdist"))) as archive:
        archive.extractall(folder, filter="data")
    (source,) = folder.iterdir()
    return source


@pytest.fixture(scope="module")
def wheel(unpacked, tmp_path_factory):
    """A wheel made of the source archive, as an index would hand it out."""
    return _built("wheel", unpacked, tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def programs(wheel, tmp_path_factory):
    """The programs of a clean environment into which the wheel of the source archive was installed."""
    return install_wheel(wheel, tmp_path_factory.mktemp("installed"))


def _run(programs, arguments, folder):
    return subprocess.run(
        [str(programs / arguments[0]), *arguments[1:]],
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
        timeout=120.0,
    )


def test_a_wheel_installs_three_names_and_nothing_else(wheel):
    top = {name.split("/")[0] for name in _names(wheel)}

    assert top == _PACKAGES | {f"truepose-{__version__}.dist-info"}


def test_a_wheel_is_typed_and_brings_its_migrations(wheel):
    names = _names(wheel)

    assert {f"{package}/py.typed" for package in _PACKAGES} <= names
    versions = {path.name for path in (CHECKOUT / "migrations" / "versions").glob("*.py")}
    assert {f"truepose/storage/migrations/versions/{name}" for name in versions} <= names


def test_a_wheel_brings_every_translation_as_it_is_read_and_no_source_of_one(wheel):
    names = _names(wheel)
    sources = (CHECKOUT / "service" / "truepose" / "messages").glob("*/LC_MESSAGES/*.po")

    expected = {f"truepose/messages/{one.parts[-3]}/LC_MESSAGES/{one.stem}.mo" for one in sources}
    assert {name for name in names if "/LC_MESSAGES/" in name} == expected != set()


def test_an_installed_program_speaks_every_language(programs, tmp_path):
    imported = "from truepose.messages.catalogue import LANGUAGES, catalogue"
    code = f"{imported}; print(*(catalogue(one).stop for one in LANGUAGES))"

    done = _run(programs, ["python", "-c", code], tmp_path)

    assert (done.stdout.split(), done.stderr) == (["."] * 4 + ["。"] * 2, "")


def test_the_source_archive_gives_the_wheel_of_the_checkout(wheel, tmp_path):
    assert _names(_built("wheel", CHECKOUT, tmp_path)) == _names(wheel)


def test_the_installed_program_says_its_version(programs, tmp_path):
    done = _run(programs, ["truepose", "--version"], tmp_path)

    assert (done.returncode, done.stdout) == (0, f"truepose {__version__}\n")


def test_a_notebook_runs_on_what_was_installed(programs, tmp_path):
    pytest.importorskip("pandas")
    shutil.copytree(CHECKOUT / "docs" / "examples", tmp_path / "docs" / "examples")
    code, said = zip(*promised(), strict=True)
    (tmp_path / "notebook.py").write_text("".join(code) + "print(tp.__file__)\n", encoding="utf-8")

    done = _run(programs, ["python", "notebook.py"], tmp_path)

    *printed, place = done.stdout.splitlines()
    assert done.returncode == 0, done.stderr
    assert "\n".join(printed) + "\n" == "".join(said)
    assert place.startswith(str(programs.parent))
