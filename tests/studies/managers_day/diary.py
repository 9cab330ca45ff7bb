"""What happened in the day, step by step: said as it happens, and kept with the time that each step took."""

import contextlib
import json
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path


@dataclass(slots=True)
class Step:
    """One thing that somebody did."""

    title: str
    took_s: float = 0.0
    seen: list[str] = field(default_factory=list)


class Diary:
    """Steps in their order."""

    def __init__(self) -> None:
        self._begun = time.monotonic()
        self.steps: list[Step] = []

    @contextlib.contextmanager
    def step(self, title: str) -> Iterator[None]:
        """Say what is done now, and afterwards how long it took."""
        step, begun = Step(title), time.monotonic()
        self.steps.append(step)
        _print(f"\n{len(self.steps)}. {title}")
        yield
        step.took_s = time.monotonic() - begun
        _print(f"   ({step.took_s:.1f} s)")

    def saw(self, sentence: str) -> None:
        """Say what a person sees now."""
        self.steps[-1].seen.append(sentence)
        _print(f"   {sentence}")

    def write(self, file: Path) -> None:
        """Keep the day as JSON, and say how long it was."""
        took_s, load = time.monotonic() - self._begun, os.getloadavg()
        told = {"took_s": took_s, "load": load, "steps": [asdict(step) for step in self.steps]}
        file.write_text(json.dumps(told, indent=1, ensure_ascii=False), encoding="utf-8")
        _print(f"\n{len(self.steps)} steps, {took_s:.0f} s, load {load[0]:.1f}: {file}")


def _print(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()
