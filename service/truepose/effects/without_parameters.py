"""Effects that no parameter of a model stands for."""

from truepose.effects.ports import NOTHING, Need, ParameterSpec, Rows, Setting, Term


class WithoutParameters:
    """What such effects have in common: they need nothing and move nothing that the arm reaches."""

    needs: frozenset[Need] = NOTHING

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return none."""
        return ()

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Return none."""
        return []
