"""Thermal growth: the links are longer the warmer it is, all at one rate.

    a_i, d_i move by  growth a_i (T - 20 degC),  growth d_i (T - 20 degC)        nominal lengths

Every nominal length a_i and d_i grows by growth times what the temperature is above 20 degC, the reference
temperature of lengths (ISO 1). The tool and the table under the base keep their sizes.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Stops
from truepose.effects.causes import Candidate, Description, FittedCause, Limits, Scene, Signature
from truepose.effects.ports import Need, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.messages.message import Text, message

NAME = "thermal_growth"
_GROWTH = "growth"
_REFERENCE_C = 20.0
_WIDTH_PER_K = 1e-4  # belief: four times what aluminium grows by
# From carbon fibre, which shrinks a little, to the softer plastics.
MATERIALS = Limits(-5e-6, 60e-6, message("limits.material"))
_SMALLEST_RANGE_K = 0.5  # over less, a metre of aluminium grows by less than a tracker's noise


class ThermalGrowth:
    """One coefficient of thermal expansion for all links."""

    name = NAME
    needs: frozenset[Need] = frozenset({"temperature"})
    traits = frozenset({Trait.OF_MATERIAL})
    signature = Signature(
        "links", "temperature", "line", "relative thermal expansion per kelvin", drawn="shift"
    )

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the coefficient of expansion."""
        return (ParameterSpec(_GROWTH, "1/K", 0.0, _WIDTH_PER_K),)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Lengthen every link that has a length: weight a_i or d_i times the kelvins above 20 degC [mm K]."""
        # One coefficient for all: the temperature that is read is one of the air or the arm, not one of each
        # link.
        warmer = warmer_k(rows.stops)
        lengths = [
            (Port(kind, joint), length)
            for joint, row in enumerate(rows.robot.joints)
            for kind, length in ((PortKind.A, row.a_mm), (PortKind.D, row.d_mm))
            if length != 0.0
        ]
        return [Term(k, port, length * warmer) for k in range(len(names)) for port, length in lengths]

    def unseen(self, scene: Scene) -> Text | None:
        """Need temperatures that differ."""
        if scene.stops.temperature_c is None or not np.isfinite(scene.stops.temperature_c).any():
            return message("unseen.no_temperature")
        if range_k(scene.stops) < _SMALLEST_RANGE_K:
            return message("unseen.steady_temperature", range_k=range_k(scene.stops))
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose growth of all links where the temperature changed."""
        if self.unseen(scene) is not None or _GROWTH in scene.present:
            return ()
        return (Candidate(NAME, "links", self.specs(scene.setting)),)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say by how much lengths follow the temperature."""
        growth, spread = float(fitted.values[0]), float(np.sqrt(fitted.covariance[0, 0]))
        reach_m = sum(abs(row.a_mm) + abs(row.d_mm) for row in scene.setting.robot.joints) / 1000.0
        over_um = 1e6 * abs(growth) * reach_m * range_k(scene.stops)
        key = "causes.thermal_growth.grow" if growth >= 0.0 else "causes.thermal_growth.shrink"
        sentence = message(key, um_per_m_k=1e6 * abs(growth), over_um=over_um)
        return Description(subject, growth, "1/K", spread, sentence, limits=MATERIALS)


def warmer_k(stops: Stops) -> FloatArray:
    """Return the temperature above 20 degC, the reference of lengths.

    Parameters
    ----------
    stops : Stops
        n rows.

    Returns
    -------
    ndarray, shape (n,)
        [K]; 0 where it is unknown.
    """
    if stops.temperature_c is None:
        return np.zeros(len(stops))
    # As if it were 20 degC: lengths of the table are those at that temperature, and nothing better is known.
    return np.nan_to_num(stops.temperature_c - _REFERENCE_C, nan=0.0)


def range_k(stops: Stops) -> float:
    """Return the span of the known temperatures [K], 0 where they are unknown."""
    if stops.temperature_c is None:
        return 0.0
    known = stops.temperature_c[np.isfinite(stops.temperature_c)]
    return float(np.ptp(known)) if known.size else 0.0
