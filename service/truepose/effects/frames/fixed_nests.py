"""Readings of fixed nests: what they leave open beside the instrument's own errors.

The world frame was fitted to readings of the fixed nests at the start, and their certified places are known
to an uncertainty. Neither moves anything that the arm reaches: no port of the chain, no cause to look for.
"""

from truepose.effects.motions import Widths, motion_specs
from truepose.effects.ports import ParameterSpec, Trait, WithoutParameters

NAME = "reference"
_FRAME_WIDTHS = Widths(1.0, 1e-3)  # a registration off by more would be a wrong one
_SMALLEST_WIDTH_MM = 1e-4  # of a certificate that claims to know its nest exactly


class Reference(WithoutParameters):
    """Parameters of the reference nests that were measured, as `reference_specs` lists them."""

    name = NAME
    traits = frozenset({Trait.NUISANCE, Trait.ON_FIXED_NESTS})


def reference_specs(uncertainty_mm: dict[int, float]) -> tuple[ParameterSpec, ...]:
    """Return the error of the registration, and of the certified place of each nest.

    Parameters
    ----------
    uncertainty_mm : dict of int to float
        Standard uncertainty per axis, by nest (1-based).

    Returns
    -------
    tuple of ParameterSpec
        Six of the frame [mm, rad], then three of each nest [mm, world], by number.
    """
    places = (
        ParameterSpec(place_name(nest, component), "mm", 0.0, max(u_mm, _SMALLEST_WIDTH_MM))
        for nest, u_mm in sorted(uncertainty_mm.items())
        for component in range(3)
    )
    # The frame first, then the places: readings of the nests cannot tell a frame that is off from nests that
    # are all off alike, and widths decide.
    return (*motion_specs("frame", _FRAME_WIDTHS), *places)


def place_name(nest: int, component: int) -> str:
    """Return e.g. `fixed_2_x` for fixed nest 2, component 0."""
    return f"fixed_{nest}_{'xyz'[component]}"
