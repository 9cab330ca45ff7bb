"""Evidence: the cells that the data ask for, as large as they ask, and none where nothing is."""

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import telling_campaign
from tests.helpers.diagnosis.selections import everything, make_start, planted, select_from
from tests.helpers.identification.synthetic import configurations
from truepose.diagnosis.evidence.signature_functions import CellProducts, CellSize, signatures_in_data
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.diagnosis.screening.normal_equations import Sums
from truepose.diagnosis.screening.significance import most_likely
from truepose.effects.signatures import signature_of
from truepose.identification.model.evaluation import Targets, evaluate

WAVES = {
    "joint_harmonics": {
        f"wave_2_{order}_{part}": np.deg2rad(0.02) / order
        for order in (1, 2, 3, 4)
        for part in ("sin", "cos")
    }
}


def pool_of(start):
    return pool_candidates(start.fit, everything(start)(start.fit))


def places(found):
    return {(signature_of(one).where, signature_of(one).over) for one in found.candidates}


@pytest.fixture(scope="module")
def wavy():
    return make_start(WAVES, n=120)


def test_a_curve_is_described_where_it_acts_over_what_it_follows(wavy):
    found = signatures_in_data(pool_of(wavy))

    assert ("joint 2", "angle of joint 2") in places(found)
    assert all(one.function for one in found.candidates)
    assert len(found.rows) == sum(len(one.specs) for one in found.candidates)


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_noise_asks_for_hardly_a_cell(seed):
    found = signatures_in_data(pool_of(make_start({}, seed=seed)))

    # each of some ninety cells has a chance of 2 % (half a chi-square of one degree beyond 4)
    assert len(places(found)) <= 6


@pytest.mark.parametrize(("stops", "seed"), [(15, 3), (30, 4)])
def test_cells_that_take_all_that_readings_left_are_described(stops, seed):
    """What is left for noise is rounding, and so is what tells these cells apart."""
    pool = pool_of(make_start({}, n=stops, seed=seed))

    found = signatures_in_data(pool)

    assert np.isfinite(found.fitted(pool).past().step()).all()


def test_what_is_described_foretells_readings_that_were_never_seen(wavy):
    pool = pool_of(wavy)
    found = signatures_in_data(pool)
    unseen = planted(WAVES, telling_campaign(60, joints_rad=configurations(60, seed=9)), seed=11).calibration

    normal = found.fitted(pool)
    step = normal.past().step()

    targets = Targets(unseen.stops, unseen.nest)
    fit = wavy.fit
    structure = fit.structure
    for one in found.candidates:
        structure = structure.extended(one.effect, one.specs)
    before = unseen.position_mm - evaluate(fit.structure, fit.values, targets).position_mm
    values = np.append(fit.values, np.zeros(len(step) - len(fit.values))) + step
    after = unseen.position_mm - evaluate(structure, values, targets).position_mm
    assert np.linalg.norm(after, axis=1).mean() < 0.7 * np.linalg.norm(before, axis=1).mean()


def test_a_cell_alone_is_as_large_as_the_same_function_alone(wavy):
    gain = [one for one in everything(wavy)(wavy.fit) if one.names == ("gain_2",)]
    pool = pool_candidates(wavy.fit, gain)
    view = pool.view()
    width = gain[0].specs[0].prior_width

    (found,) = signatures_in_data(pool).candidates

    alone = most_likely(view.gram(0) * width**2, view.towards * width, view.sums, widest=1.0)
    assert found.specs[0].prior_width == pytest.approx(alone.width * width)


def test_no_cell_is_larger_than_anybody_believes(wavy):
    """However loud the readings are, physics holds: what is beyond it stays in the residuals."""
    loud = make_start({"joint_gain": {"gain_4": 2e-3}}, noise_mm=0.2)
    pool = pool_of(loud)

    believed = {spec.name: spec.prior_width for one in pool.all for spec in one.specs}
    for one in signatures_in_data(pool).candidates:
        assert all(spec.prior_width <= believed[spec.name] * (1.0 + 1e-9) for spec in one.specs)


def test_picks_compete_with_the_cells_that_they_stand_in(wavy):
    selected = select_from(wavy, everything(wavy))
    assert selected.picks

    found = signatures_in_data(selected.pool, selected.picks)

    names = [name for one in found.candidates for name in one.names]
    assert len(names) == len(set(names))
    cell = signature_of(selected.picks[0])
    assert (cell.where, cell.over) in places(found)


def test_nothing_proposed_is_nothing_described(wavy):
    found = signatures_in_data(pool_candidates(wavy.fit, ()))

    assert found.candidates == ()
    assert found.rows.size == 0


def make_cells(sizes, n=300, seed=5):
    """Products of cells of so many columns, of which the first two are in the residuals."""
    rng = np.random.default_rng(seed)
    columns = 0.2 * rng.standard_normal((sum(sizes), n))
    columns[-1] = columns[0] + 1e-3 * columns[-1]  # the last cell is nearly a part of the first
    residual = rng.standard_normal(n) + np.full(sum(sizes[:2]), 3.0) @ columns[: sum(sizes[:2])]
    ends = np.cumsum(sizes)
    runs = tuple(np.arange(end - size, end) for size, end in zip(sizes, ends, strict=True))
    sums = Sums(float(residual @ residual), float(n), float(n), 1.0)
    return CellProducts(columns @ columns.T, columns @ residual, sums, runs)


def test_cells_sized_together_are_sized_as_each_by_itself():
    cells = make_cells((3, 1, 2, 3, 1))
    held = {1: CellSize(10.0, 0.5, 4.0)}

    together = cells.sizes((0, 2, 3, 4), held)

    for cell, size in together.items():
        assert size == pytest.approx(cells.sizes((cell,), held)[cell], rel=1e-9)


def test_cells_sized_anew_are_each_sized_past_the_others_and_what_gains_too_little_goes_out():
    cells = make_cells((3, 1, 2, 3, 1))
    held = {cell: CellSize(10.0, 0.5, 4.0) for cell in range(5)}

    by_hand = dict(held)
    for cell in held:
        del by_hand[cell]
        size = cells.sizes((cell,), by_hand)[cell]
        if size.gain >= 2.0:
            by_hand[cell] = size
    found = cells.sized_anew(held)

    assert {0, 1} <= found.keys() < held.keys()
    assert found.keys() == by_hand.keys()
    for cell, size in found.items():
        assert size == pytest.approx(by_hand[cell], rel=1e-6)
