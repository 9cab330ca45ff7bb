"""Tables as a terminal shows them."""

import io

from rich.console import Console


def printed(*tables, width=300):
    console = Console(file=io.StringIO(), width=width)
    console.print(*tables)
    return console.file.getvalue()
