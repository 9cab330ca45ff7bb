"""Certified places of the tool nests are known to an uncertainty: small errors that need no cause.

An identification holds certified nests and carries their uncertainty afterwards (docs/decisions/0006); a
diagnosis lets them move within it, so that what a certificate allows is never named a nest that is out of
place.
"""

from collections.abc import Collection

from truepose.effects.ports import NOTHING, Need, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait

NAME = "tool_certificate"


class ToolCertificate:
    """Deviations of certified nests within the uncertainty of their certificates."""

    name = NAME
    needs: frozenset[Need] = NOTHING
    # Held still, an error of a few micrometres that all readings of a nest share would be found as a cause.
    traits = frozenset({Trait.NUISANCE})

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return none: `certificate_specs` has them."""
        return ()

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Act on the nest's coordinate, one to one."""
        return [Term(k, Port(PortKind.NEST, _number(name)), 1.0) for k, name in enumerate(names)]


def certificate_specs(uncertainty_mm: dict[int, float]) -> tuple[ParameterSpec, ...]:
    """Return the errors of certified nests, as wide as their certificates say; none of exact ones.

    Parameters
    ----------
    uncertainty_mm : dict of int to float
        Standard uncertainty per axis, by nest (1-based).
    """
    return tuple(
        ParameterSpec(_name(nest, axis), "mm", 0.0, u_mm)
        for nest, u_mm in sorted(uncertainty_mm.items())
        for axis in "xyz"
        # A prior of no width is no parameter: the nest is then exactly where it is certified.
        if u_mm > 0.0
    )


def moves(nest: int, names: Collection[str]) -> bool:
    """Say whether a certified nest (1-based) may move by one of these parameters."""
    return _name(nest, "x") in names


def _name(nest: int, axis: str) -> str:
    return f"certified_{nest}_{axis}"


def _number(name: str) -> int:
    _, nest, axis = name.split("_")
    return 3 * (int(nest) - 1) + "xyz".index(axis)
