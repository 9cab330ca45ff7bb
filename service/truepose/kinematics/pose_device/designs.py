"""How six legs can join three base cups and three tool nests so that the pose has a closed form.

One cup carries two legs, one three, one a single leg: the pattern triple-double-single, in which leg ij joins
base cup i and tool nest j: 11, 12, 21, 22, 23, 31. Every permutation of cups and of nests is a design of its
own. The other pattern of six legs between two triangles (each cup to two nests) has no such cascade and is
ill conditioned when all legs are equal.

References
----------
A. Nubiola, PhD thesis, ETS Montreal, 2014, section 3.2.
"""

from dataclasses import dataclass
from itertools import combinations, permutations

from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.ballbar import Leg

PATTERN: tuple[Leg, ...] = ((1, 1), (2, 1), (3, 1), (1, 2), (2, 2), (2, 3))  # in the order of the cascade

_TOOL = (1, 2, 3)


@dataclass(frozen=True, slots=True)
class Design:
    """Which cups and nests play the parts 1, 2, 3 of the pattern."""

    base: tuple[int, int, int]
    tool: tuple[int, int, int]

    @property
    def legs(self) -> tuple[Leg, ...]:
        """The six legs, in the order of the cascade: three to the first nest, two to the second, one."""
        return tuple((self.base[i - 1], self.tool[j - 1]) for i, j in PATTERN)

    @property
    def name(self) -> str:
        """The thesis' name: each base cup in ascending order, followed by its nests, e.g. 1_12 2_123 3_1."""
        nests = {cup: sorted(j for i, j in self.legs if i == cup) for cup in sorted(self.base)}
        return " ".join(f"{cup}_" + "".join(map(str, joined)) for cup, joined in nests.items())


def designs(base_points: int = 3) -> tuple[Design, ...]:
    """Return all designs on any three of the base cups: 36 for three cups, 144 for four.

    Raises
    ------
    ConfigurationError
        There are fewer than three cups.
    """
    if base_points < 3:
        raise ConfigurationError(f"The base fixture has {base_points} cups; three or more are needed.")
    return tuple(
        Design((b1, b2, b3), (t1, t2, t3))
        for chosen in combinations(range(1, base_points + 1), 3)
        for b1, b2, b3 in permutations(chosen)
        for t1, t2, t3 in permutations(_TOOL)
    )


DESIGNS = designs()
