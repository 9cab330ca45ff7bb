"""Causes that the night's seed plants in a sound robot: each is to be named, or to stand beside the name.

Sizes are twice those at which a real robot shows them (A. Nubiola, thesis, ETS Montreal 2014, table 2.3; what
moves with time: what a session in a workshop meets), for the 50 configurations of a night.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from truepose.demo.cell_run import CellRequest
from truepose.demo.truth_comparison import JudgedRun
from truepose.exchange.cells.file import scenario_text
from truepose.night.calibrated_cells import CalibratedCell, found, list_findings
from truepose.night.check import Check, convergence_check

_CALIBRATION: Final = 50
_VALIDATION: Final = 100
_HALF_WAY_S: Final = 900.0  # of a calibration of 50 configurations


@dataclass(frozen=True, slots=True)
class _PlantedCause:
    """What is wrong with the robot, as a scenario says it."""

    effect: str
    subject: str
    amplitude: float
    details: Mapping[str, Any]

    @property
    def scenario(self) -> str:
        """The scenario's text."""
        said = {"name": self.effect, "subject": self.subject, "amplitude": self.amplitude, **self.details}
        return scenario_text("irb120-clean", "effect", [said])

    @property
    def words(self) -> str:
        """What is to be named."""
        return f"{self.effect} of {self.subject}"


def _wave(rng: np.random.Generator) -> _PlantedCause:
    joint, amplitude_deg = ((4, 0.04), (6, 0.06))[int(rng.integers(2))]
    return _PlantedCause(
        "joint_harmonics", f"joint {joint}", amplitude_deg, {"order": float(rng.integers(1, 101))}
    )


def _gain(rng: np.random.Generator) -> _PlantedCause:
    joint, amplitude = ((2, 4e-4), (5, 8e-4))[int(rng.integers(2))]
    return _PlantedCause("joint_gain", f"joint {joint}", amplitude, {})


def _coupling(_rng: np.random.Generator) -> _PlantedCause:
    return _PlantedCause("joint_coupling", "joint 6", 1e-3, {"source": "joint 5"})


def _nest(rng: np.random.Generator) -> _PlantedCause:
    # Nest 1 faces the tracker in one configuration of twenty: its readings pass for single bad ones.
    return _PlantedCause("nest_offset", f"nest {rng.integers(2, 4)}", 0.12, {})


def _jump(rng: np.random.Generator) -> _PlantedCause:
    from_s = float(rng.uniform(0.8, 1.2)) * _HALF_WAY_S
    return _PlantedCause("base_shift", "base", 0.16, {"rotation_rad": 2e-4, "from_s": from_s})


_KINDS: Final[Mapping[str, Callable[[np.random.Generator], _PlantedCause]]] = {
    "wave": _wave,
    "gain": _gain,
    "coupling": _coupling,
    "nest": _nest,
    "jump": _jump,
}


def planted_causes(seed: int) -> list[CalibratedCell]:
    """Return the case of each kind of cause, where and how large as the seed draws."""
    return [_case(name, draw, seed, number) for number, (name, draw) in enumerate(_KINDS.items())]


def _case(
    name: str, draw: Callable[[np.random.Generator], _PlantedCause], seed: int, number: int
) -> CalibratedCell:
    planted = draw(np.random.default_rng((seed, number)))
    request = CellRequest("irb120-clean", seed, _CALIBRATION, _VALIDATION)
    return CalibratedCell(
        f"irb120-planted-{name}", request, lambda judged: _checks(judged, planted), planted.scenario
    )


def _checks(judged: JudgedRun, planted: _PlantedCause) -> list[Check]:
    findings = list_findings(judged)
    named = [one for one in findings if _is(one, planted)]
    beside = [one for one in findings if any(_is(rival, planted) for rival in one["confusable_with"])]
    checks = [
        convergence_check(judged.run.identification),
        Check("cause", planted.words, found(judged), bool(named or beside)),
    ]
    return checks if not named else [*checks, _amplitude(named[0], planted)]


def _is(told: Mapping[str, Any], planted: _PlantedCause) -> bool:
    return (told["effect"], told["subject"]) == (planted.effect, planted.subject)


def _amplitude(finding: Mapping[str, Any], planted: _PlantedCause) -> Check:
    # Four standard uncertainties: once in 16,000 by chance.
    off = abs(abs(finding["amplitude"]) - planted.amplitude) / finding["amplitude_standard_uncertainty"]
    said = f"{finding['amplitude']:.4g} {finding['unit']}, {off:.1f} standard uncertainties off"
    target = f"{planted.amplitude:g} within 4 standard uncertainties"
    return Check("amplitude", target, said, off <= 4.0, off)
