"""What the cell of now says of a session that was planned in that of then."""

from dataclasses import replace

import pytest

from tests.helpers.ballbar.cells import domain_cell
from truepose.domain.cell import SimulatedCell
from truepose.sessions.cell import CurrentCell
from truepose.sessions.errors import PlanRefusedError

REAL = replace(domain_cell(), simulated=None)
SIMULATED = replace(REAL, simulated=SimulatedCell("irb120-tilted", 1))


@pytest.mark.parametrize(
    ("then", "now", "said"),
    [(SIMULATED, REAL, "in a simulated cell, but this cell is real"),
     (REAL, SIMULATED, "in a real cell, but this cell is simulated")],
)  # fmt: skip
def test_a_session_never_goes_on_where_what_is_simulated_and_what_is_real_would_be_mixed(then, now, said):
    with pytest.raises(PlanRefusedError, match=said):
        CurrentCell(now).bound(then)


@pytest.mark.parametrize("cell", [REAL, SIMULATED])
def test_a_session_goes_on_in_the_kind_of_cell_that_it_was_planned_in(cell):
    assert CurrentCell(cell).bound(cell).simulated == cell.simulated
