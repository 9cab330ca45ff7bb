"""The `truepose` command; thin, like the web."""

from truepose.cli.program import main

__all__ = ["main"]
