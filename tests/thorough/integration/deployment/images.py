"""An image without an engine: what a Dockerfile copies, in a folder of its own, run by a plain interpreter.

Third-party packages come from the environment of the tests, by path and without its `.pth` files, so that
the checkout itself, installed there as editable, cannot be imported.
"""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

from tests.integration.deployment.deployment_files import CHECKOUT

_ENDS_IN_S = 15.0
CONSECUTIVE_PORTS = 5


def copy_sources(dockerfile, folder):
    """Do what the COPY instructions do."""
    for sources, destination in dockerfile.copies():
        for source in sources:
            found = CHECKOUT / source
            if found.is_dir():
                # With what is compiled of each file: it counts for this file only, wherever it lies.
                shutil.copytree(found, folder / destination, symlinks=True)
            else:
                shutil.copy(found, folder / destination)
    return folder


def environment(**more):
    site_packages = sysconfig.get_paths()["purelib"]
    kept = {name: value for name, value in os.environ.items() if not name.startswith("TRUEPOSE")}
    return {**kept, "PYTHONPATH": site_packages, **more}


def install(source, folder):
    """Build a wheel of `source`, install it into a fresh environment and return its folder of programs."""
    wheels = folder / "wheels"
    _pip("wheel", str(source), "--no-index", "--no-build-isolation", "--wheel-dir", str(wheels))
    (wheel,) = wheels.glob("truepose-*.whl")
    return install_wheel(wheel, folder)


def install_wheel(wheel, folder):
    """Install a wheel into a fresh environment and return its folder of programs."""
    venv.create(folder / "venv", with_pip=False)
    programs = folder / "venv" / "bin"
    _pip("--python", str(programs / "python"), "install", "--no-index", str(wheel))
    return programs


def _pip(*arguments):
    command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", *arguments, "--no-deps"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}"


@contextlib.contextmanager
def running(command, folder, env):
    """Run a command of the compose file and yield its standard output; it ends politely or the test fails."""
    process = subprocess.Popen(command, cwd=folder, env=env, stdout=subprocess.PIPE, text=True)
    try:
        yield process.stdout
        assert process.poll() is None, f"{command} ended by itself with {process.returncode}"
    finally:
        process.terminate()
        try:
            process.wait(_ENDS_IN_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            raise
        finally:
            process.stdout.close()


def replaced(command, replacements):
    """Return a command with some of its words, or parts of words, replaced: addresses, ports, folders."""
    words = list(command)
    for old, new in replacements.items():
        assert any(old in word for word in words), f"{old} is not in {command}"
        words = [word.replace(old, new) for word in words]
    return words


def on_this_interpreter(command, programs=None):
    """Return a command with its program resolved as the image would resolve it."""
    if programs is None:
        assert command[0] == "python"
        # -S: without it the interpreter would read the .pth file of the editable checkout.
        return [sys.executable, "-S", *command[1:]]
    assert (programs / command[0]).is_file(), f"no program {command[0]}"
    return [str(programs / command[0]), *command[1:]]


def announced(stdout, count=1):
    """Return so many JSON lines from a program's standard output."""
    lines = [stdout.readline() for _ in range(count)]
    assert all(lines), "the program ended before it was ready"
    return [json.loads(line) for line in lines]


def healthy(test, programs, env, folder):
    """Run a health check of the compose file and return whether it passes."""
    assert test[0] == "CMD"
    command = on_this_interpreter(test[1:], programs)
    return (
        subprocess.run(command, cwd=folder, env=env, check=False, capture_output=True, timeout=10).returncode
        == 0
    )


def networked_cell(folder, first_port):
    """Write the cell file of the compose network as it looks from this machine; returns its path."""
    text = (CHECKOUT / "docs" / "examples" / "networked-cell.toml").read_text(encoding="utf-8")
    text = text.replace('host = "cell"', 'host = "127.0.0.1"')
    for offset in range(CONSECUTIVE_PORTS):
        text = text.replace(f"port = {7000 + offset}\n", f"port = {first_port + offset}\n")
    path = Path(folder) / "cell.toml"
    path.write_text(text, encoding="utf-8")
    return path
