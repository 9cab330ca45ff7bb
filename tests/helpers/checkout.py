"""Where this checkout lies, and what a plain interpreter puts on its path to run it."""

from pathlib import Path

CHECKOUT = Path(__file__).parents[2]
SOURCES = tuple(str(CHECKOUT / folder) for folder in ("service", "drivers", "simulators"))
