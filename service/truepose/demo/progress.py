"""What a run shows while it works: bars on a terminal, one line a phase elsewhere; on standard error."""

import contextlib
from collections.abc import Iterator

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from truepose.demo.client import Told


class RunProgress:
    """Shows the phases of a run; `doing` says what is under way, for whoever has to say where it stopped."""

    def __init__(self, console: Console, bars: Progress) -> None:
        self._console = console
        self._bars = bars
        self.doing = "starting"

    @contextlib.contextmanager
    def phase(self, title: str) -> Iterator[Told]:
        """Show a phase; yields what is to be told how far it is."""
        self.doing = title
        if not self._console.is_terminal:
            self.say(title)
        bar = self._bars.add_task(title, total=None)

        def told(done: int, planned: int, doing: str) -> None:
            self.doing = f"{title} ({doing})"
            self._bars.update(bar, completed=done, total=planned)

        yield told
        # Bars are found by their number: those of earlier chapters are gone, so it is no place in a list.
        (task,) = (task for task in self._bars.tasks if task.id == bar)
        total = task.total or 1  # a phase that told nothing is one step
        self._bars.update(bar, completed=total, total=total)
        self._bars.stop_task(bar)

    def chapter(self, title: str) -> None:
        """Begin with the next of several runs: its bars take the place of the ones before."""
        for bar in self._bars.task_ids:
            self._bars.remove_task(bar)
        self.say(title)

    def say(self, sentence: str) -> None:
        """Print a sentence beside the bars."""
        self._console.print(sentence, soft_wrap=True, markup=False)


@contextlib.contextmanager
def progress_bar() -> Iterator[RunProgress]:
    """Show progress on standard error while the context lasts."""
    console = Console(stderr=True, highlight=False)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal) as bars:
        yield RunProgress(console, bars)
