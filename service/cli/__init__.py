"""The `truepose` command; thin, like the web."""

from service.cli.program import main

__all__ = ["main"]
