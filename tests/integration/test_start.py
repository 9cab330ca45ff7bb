"""A command imports what it uses: whole processes, by what they have loaded when they end."""

import os
import subprocess
import sys
from pathlib import Path

from tests.helpers.archive import written_archive

CAMPAIGN = Path(__file__).parents[2] / "docs" / "examples" / "campaign"
LOADED = """
import sys
from truepose.cli import main
status = main()
sys.stderr.write(" ".join(sys.modules))
sys.exit(status)
"""


def ended(*arguments: str, threads: str = "1") -> subprocess.CompletedProcess[str]:
    """Run a command in a shell that allows so many threads of linear algebra."""
    shell = os.environ | {"OPENBLAS_NUM_THREADS": threads, "OMP_NUM_THREADS": threads}
    command = [sys.executable, "-c", LOADED, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True, env=shell)


def loaded(*arguments: str) -> set[str]:
    return set(ended(*arguments).stderr.split())


def test_to_identify_takes_neither_scipy_nor_figures():
    modules = loaded("identify", str(CAMPAIGN))

    assert "truepose.identification.identify" in modules
    assert not {"scipy", "matplotlib", "pandas"} & modules


def test_a_shell_that_allows_more_threads_gets_the_same_bits(tmp_path):
    campaign = written_archive(tmp_path, (40,)) / "campaign-1"  # large enough for several threads

    one, two = (ended("identify", str(campaign), "--json", threads=count) for count in ("1", "2"))

    assert one.stdout == two.stdout
    assert not {"scipy", "matplotlib", "pandas"} & {*one.stderr.split()}


def test_one_command_does_not_import_the_others():
    modules = loaded("identify", "--help")

    assert "truepose.cli.campaigns" in modules
    assert "truepose.cli.services" not in modules


def test_help_lists_every_command():
    command = [sys.executable, "-m", "truepose", "--help"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout

    names = (
        "identify",
        "diagnose",
        "predict",
        "validate",
        "demo",
        "serve",
        "inspect",
        "verify",
        "nightly",
        "backup",
        "restore",
    )
    assert all(name in printed for name in names)
