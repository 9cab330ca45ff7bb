"""A command imports what it uses: whole processes, by what they have loaded when they end."""

import subprocess
import sys
from pathlib import Path

import pytest

CAMPAIGN = Path(__file__).parents[4] / "docs" / "examples" / "campaign"
LOADED = """
import sys
from truepose.cli import main
status = main()
sys.stderr.write(" ".join(sys.modules))
sys.exit(status)
"""


def loaded(*arguments: str) -> set[str]:
    command = [sys.executable, "-c", LOADED, *arguments]
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    return set(ended.stderr.split())


@pytest.mark.parametrize("output", [(), ("--json",)], ids=["tables", "json"])
def test_to_identify_takes_neither_scipy_nor_figures(output):
    modules = loaded("identify", str(CAMPAIGN), *output)

    assert "truepose.identification.identify" in modules
    assert not {"scipy", "matplotlib", "pandas"} & modules


def test_one_command_does_not_import_the_others():
    assert "truepose.cli.calibration.campaigns" in loaded("identify", "--help")
    assert "truepose.cli.cells" not in loaded("identify", "--help")


def test_help_lists_every_command():
    ended = subprocess.run(
        [sys.executable, "-m", "truepose", "--help"], capture_output=True, text=True, check=True
    )

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
    assert all(name in ended.stdout for name in names)
