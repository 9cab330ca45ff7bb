from io import StringIO

from rich.console import Console
from rich.progress import Progress

from truepose.demo.progress import RunProgress


def test_a_later_run_shows_its_phases_after_the_bars_of_the_first_are_gone():
    console = Console(file=StringIO())
    progress = RunProgress(console, Progress(console=console, disable=True))

    for cell in ("first", "second"):
        progress.chapter(cell)
        with progress.phase(f"measuring the {cell} cell") as told:
            told(3, 3, "configuration 3")

    assert console.file.getvalue().splitlines()[-2:] == ["second", "measuring the second cell"]
