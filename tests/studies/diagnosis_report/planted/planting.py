"""What is hidden in a simulated campaign, and which names for it would be right."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from truepose.domain.diagnosis import Cause

Detail = float | str | list[float]


@dataclass(frozen=True, slots=True)
class Planted:
    """One planted effect, in the words and units of scenario files."""

    effect: str
    subject: str
    amplitude: float
    details: Mapping[str, Detail] = field(default_factory=dict)
    from_s: float = 0.0
    # Every name that is right with the amplitude that belongs to it, None where none is defined; what
    # several joints share may be named joint by joint.
    right: Mapping[Cause, float | None] = field(default_factory=dict)

    @property
    def order(self) -> float | None:
        """Periods per turn of a planted wave."""
        order = self.details.get("order")
        return order if isinstance(order, float) else None


Draw = Callable[[np.random.Generator, int], Planted]


@dataclass(frozen=True, slots=True)
class Case:
    """An effect at the size at which a real robot shows it; what is left open is drawn per seed."""

    label: str
    draw: Draw  # the number of readings tells how long the campaign lasts
    scenario: str = "irb120-tilted"
    start: tuple[str, ...] | None = None  # effects that the diagnosis starts from, None: its default

    def planted(self, seed: int, readings: int, factor: float = 1.0) -> Planted:
        """Return what this seed hides, `factor` times the usual amplitude."""
        rng = np.random.default_rng([seed, *self.label.encode()])
        return scaled(self.draw(rng, readings), factor)


# Sizes that belong to an amplitude and grow with it. Bad readings grow, they do not become more frequent.
_GROWING = ("rotation_rad", "rotation_rad_per_h", "centre_shift_mm", "size_mm")


def scaled(planted: Planted, factor: float) -> Planted:
    """Return the same effect `factor` times as large."""
    details = {
        key: _times(value, factor) if key in _GROWING else value for key, value in planted.details.items()
    }
    if "size_mm" in details:
        return replace(planted, details=details)
    right = {cause: true and factor * true for cause, true in planted.right.items()}
    return replace(planted, amplitude=factor * planted.amplitude, details=details, right=right)


def _times(value: Detail, factor: float) -> Detail:
    match value:
        case float():
            return factor * value
        case list():
            return [factor * part for part in value]
    return value


def scenario_text(
    extends: str, planted: tuple[Planted, ...], *, heavy_tails: bool = False, over_time: bool = True
) -> str:
    """Return a scenario file: a shipped cell with planted effects.

    `heavy_tails` gives Student's noise of 4 degrees of freedom, scaled to the stated deviation. Without
    `over_time` an everyday robot neither drifts nor warms up.
    """
    lines = [f"extends = {json.dumps(extends)}"]
    if heavy_tails:
        lines += ["[tracker]", "noise_degrees_of_freedom = 4.0"]
    if not over_time:
        lines += ["[everyday]", "over_time = false"]
    for effect in planted:
        stated = {"name": effect.effect, "subject": effect.subject, "amplitude": effect.amplitude}
        entries = {**stated, "from_s": effect.from_s, **effect.details}
        # Strings, numbers and lists of numbers read the same in TOML as in JSON.
        lines += ["[[effect]]", *(f"{key} = {json.dumps(value)}" for key, value in entries.items())]
    return "\n".join(lines) + "\n"
