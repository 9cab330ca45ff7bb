r"""Refinement of what was chosen: the moments of jumps, and the orders of lines between whole ones.

*Jumps.* Of many readings only some gaps are tried; what jumped is then placed in the very gap. A moment that
is off by some readings leaves these on the wrong side: they would pass for bad ones. So they weigh here as
they did before any jump was known. A jump between two tried moments is often chosen at both of them, one
after the other: two that meet in one gap are one jump.

*Lines.* The stages of a gear need not turn whole times per turn of the joint. Waves are looked for at whole
orders. A line of another order leaves waves at those beside it, which together resemble it over what was
measured: within T turns, orders that differ by less than 1 / T are hardly two. So once waves are selected,
each bunch of them is weighed by BIC against one line of a free order. With nu degrees of freedom, R the sum
of squares without the bunch and E what a line explains of it, the order is where the gain nu ln(R / (R - E))
is largest; its variance is -2 over the gain's second derivative there.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from truepose.diagnosis.screening.candidates import View, pool_candidates
from truepose.diagnosis.screening.selection import Propose, Selection, names_of, reselect
from truepose.diagnosis.screening.significance import screen
from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Detail
from truepose.effects.causes import Candidate, Scene
from truepose.effects.names import joint_of_subject
from truepose.effects.ports import Trait
from truepose.effects.registry import CAUSES, effects_with
from truepose.effects.signatures import signature_of
from truepose.effects.waves import is_whole, orders, wave_specs
from truepose.identification.fit.robust import RobustFit, fit


def with_exact_moments(start: RobustFit, selected: Selection, propose: Propose, scene: Scene) -> Selection:
    """Return the selection with every jump in the gap between two stops that explains most.

    Parameters
    ----------
    start : RobustFit
        Of the model without picks, with its decisions about readings.
    selected : Selection
    propose : callable
        From a fit to every way in which it may still be wrong.
    scene : Scene
        Of the start.

    Returns
    -------
    Selection
        The same one where nothing jumped, or every jump is in its gap already.
    """
    jumps = [pick for pick in selected.picks if signature_of(pick).shape == "jump"]
    if not jumps:
        return selected
    # With the weights of the start: readings on the wrong side of a moment pass for bad ones in the extended
    # fit, and without weight they would not draw the moment to its gap.
    solution = fit(selected.fit.structure, start.blocks, selected.fit.values)
    weighed = replace(selected.fit, blocks=start.blocks, solution=solution, gross=start.gross)
    placed = {pick.names: _placed(weighed, selected, pick, scene) for pick in jumps}
    found = (placed.get(pick.names, pick) for pick in selected.picks)
    # Two jumps that meet in one gap have the same names: they are one jump, and together would be singular.
    picks = tuple({pick.names: pick for pick in found}.values())
    return selected if picks == selected.picks else reselect(start, selected, picks, propose)


def _placed(weighed: RobustFit, selected: Selection, jump: Candidate, scene: Scene) -> Candidate:
    """Return a jump in the gap that explains most between the moments that were tried beside it."""
    tried = [
        one.variant for one in selected.pool.all if (one.effect, one.subject) == (jump.effect, jump.subject)
    ]
    before = max((moment for moment in tried if moment < jump.variant), default=-np.inf)
    after = min((moment for moment in tried if moment > jump.variant), default=np.inf)
    # The jump's own parameters are taken out of what is present, or it would not be proposed again.
    others = replace(scene, present=scene.present - set(jump.names), between_s=(before, after))
    found = [one for one in CAUSES[jump.effect].candidates(others) if _same_place(one, jump)]
    if not found:
        return jump
    view = pool_candidates(weighed, found).view(without=jump.names)
    return found[int(np.argmax(screen(view).explained))]


def _same_place(one: Candidate, jump: Candidate) -> bool:
    """Whether a candidate is a jump of the same thing."""
    return one.subject == jump.subject and signature_of(one).shape == "jump"


_CLEARLY = 8.0  # in BIC, as between two names
_PERIODS = 1.0  # within what was measured, at least: less of a wave is a slow curve of no sure form
_TRIED = 10  # orders over the width of a line, and again from one of them to the next
_DECIMALS = 3  # of an order in names


def with_lines_between(start: RobustFit, selected: Selection, propose: Propose, scene: Scene) -> Selection:
    """Return the selection with lines between whole orders where they are clearly the better story.

    Measured on simulated campaigns: of 30 lines of 5 to 40 periods, 25 were found with their order, and 5
    that are nearly whole as whole ones; none of 35 whole waves and 46 pairs of waves was taken for a line.

    Parameters
    ----------
    start : RobustFit
        Of the model without picks.
    selected : Selection
    propose : callable
        From a fit to every way in which it may still be wrong.
    scene : Scene
        Of the start.

    Returns
    -------
    Selection
        The same one where no line is the better story.
    """
    while True:
        # Lazily, and from the beginning after each: the fit has changed, and with it what every other bunch
        # explains.
        found = ((bunch, _line(selected, bunch, scene)) for bunch in _bunches(selected.picks, scene))
        bunch, line = next((one for one in found if one[1] is not None), ((), None))
        if line is None:
            return selected
        others = tuple(pick for pick in selected.picks if pick not in bunch)
        selected = reselect(start, selected, (*others, line), propose)


def _bunches(picks: Sequence[Candidate], scene: Scene) -> list[tuple[Candidate, ...]]:
    """Return each curve, and the waves of each joint that may be one line between whole orders."""
    waves = [pick for pick in picks if pick.effect in effects_with(Trait.WAVES)]
    found: list[tuple[Candidate, ...]] = [(pick,) for pick in waves if pick.function]
    for subject in dict.fromkeys(pick.subject for pick in waves):
        own = [pick for pick in waves if pick.subject == subject and not pick.function]
        found += _beside_each_other(own, 1.0 + _width(scene, joint_of_subject(subject)))
    return [bunch for bunch in found if len(bunch) > 1 or is_whole(bunch[0].variant)]


def _beside_each_other(waves: Sequence[Candidate], reach: float) -> list[tuple[Candidate, ...]]:
    """Return the waves of one joint in runs of neighbouring orders, at most `reach` apart."""
    bunches: list[tuple[Candidate, ...]] = []
    for wave in sorted(waves, key=lambda one: one.variant):
        if bunches and wave.variant - bunches[-1][-1].variant <= reach:
            bunches[-1] = (*bunches[-1], wave)
        else:
            bunches.append((wave,))
    return bunches


def _width(scene: Scene, joint: int) -> float:
    """Return by how much orders must differ to be two, within the turns that a joint was measured over."""
    # Rayleigh's limit: within T turns, two waves drift apart by one period where their orders differ by 1 /
    # T.
    return 2.0 * np.pi / max(float(np.ptp(scene.turn_rad[:, joint])), 1e-9)


def _line(selected: Selection, bunch: tuple[Candidate, ...], scene: Scene) -> Candidate | None:
    """Return the line that is a better story than a bunch; None where there is none."""
    line = _best_line(selected, bunch, scene)
    if line is None:
        return None
    # The bunch as one candidate: all its waves together compete with the one line.
    together = bunch[0]._replace(specs=tuple(spec for wave in bunch for spec in wave.specs))
    view = _without(bunch, selected, (line, together))
    found = float(np.log(len(orders(scene, joint_of_subject(line.subject)))))
    parameter = float(np.log(max(view.sums.observations / view.sums.alike, 2.0)))
    # A line pays for three parameters (sine, cosine, order) and one search, each wave for two and one search.
    as_line, as_waves = _gain(view) - [3.0 * parameter + 2.0 * found, 2.0 * len(bunch) * (parameter + found)]
    as_bunch = float(screen(view).score[1]) if together.function else as_waves
    # Waves beside each other are what a line leaves; a single one is the plainer story of the two.
    return line if as_line > as_bunch + (_CLEARLY if len(bunch) == 1 else 0.0) else None


def _best_line(selected: Selection, bunch: tuple[Candidate, ...], scene: Scene) -> Candidate | None:
    """Return the line of the free order that gains most beside a bunch; None where no order is left to try.

    Orders are tried a tenth of a line's width apart, then a hundredth of it about the best of these.
    """
    width = _width(scene, joint_of_subject(bunch[0].subject))
    low, high = bunch[0].variant - 1.0, bunch[-1].variant + 1.0
    lowest = max(_PERIODS * width, 1.0 if bunch[0].function else low)
    if lowest >= high:
        return None
    step = width / _TRIED
    tried = np.arange(lowest, high, step)
    for closer in (np.arange(-_TRIED, _TRIED + 1) * step / _TRIED, np.zeros(1)):
        lines = [_of_order(bunch[0], order) for order in tried.tolist()]
        best = lines[int(np.argmax(_gain(_without(bunch, selected, lines))))]
        tried = best.variant + closer
    return best


def _of_order(wave: Candidate, order: float) -> Candidate:
    """Return a wave of another order on the same joint."""
    named = round(order, _DECIMALS)
    specs = wave_specs(joint_of_subject(wave.subject), named)
    return Candidate(wave.effect, wave.subject, specs, named)


def _without(bunch: Sequence[Candidate], selected: Selection, candidates: Sequence[Candidate]) -> View:
    """Return candidates as they stand at the selection's fit, the bunch left out."""
    return pool_candidates(selected.fit, candidates).view(without=names_of(bunch))


def _gain(view: View) -> FloatArray:
    """Return by how much each candidate adds to twice the log likelihood: nu ln(R / (R - T)), shape (C,).

    The noise is profiled out; counts are those of readings that are worth one.
    """
    sums, explained = view.sums, screen(view).explained
    left = np.maximum(sums.residual_square - explained, 1e-300)
    return np.asarray(sums.degrees / sums.alike * np.log(sums.residual_square / left))


def with_known_orders(
    selected: Selection, group: Sequence[Candidate], details: tuple[Detail, ...], scene: Scene
) -> tuple[Detail, ...]:
    """Return the details of waves, with the standard uncertainty of each order that is not whole.

    So far as the order may be another, so is the phase at the joint's zero: u(phase)^2 grows by (u(order)
    q)^2, q the mean angle at which the line was measured.

    Parameters
    ----------
    selected : Selection
    group : sequence of Candidate
        Picks of one cause.
    details : tuple of Detail
        An order comes before its phase.
    scene : Scene

    Returns
    -------
    tuple of Detail
    """
    known: list[Detail] = []
    order_u = mean_turn = 0.0
    waves = [pick for pick in group if pick.effect in effects_with(Trait.WAVES)]
    lines = {pick.variant: pick for pick in waves if not is_whole(pick.variant)}
    for detail in details:
        if detail.name == "order":
            line = lines.get(detail.value)
            order_u = 0.0 if line is None else _uncertainty(selected, line, scene)
            mean_turn = 0.0 if line is None else _mean_turn_deg(scene, line)
            detail = replace(detail, standard_uncertainty=order_u)
        elif detail.name == "phase":
            spread = float(np.hypot(detail.standard_uncertainty, order_u * mean_turn))
            detail = replace(detail, standard_uncertainty=spread)
        known.append(detail)
    return tuple(known)


def _mean_turn_deg(scene: Scene, line: Candidate) -> float:
    """Return the mean angle of a line's joint [deg]."""
    return float(np.rad2deg(scene.turn_rad[:, joint_of_subject(line.subject)].mean()))


def _uncertainty(selected: Selection, line: Candidate, scene: Scene) -> float:
    """Return the standard uncertainty of an order, from the curvature of its likelihood.

    With g(o) twice the log likelihood, u^2 = -2 / g''(o), by differences over half the step of the search;
    the width of a line where g does not bend downwards.
    """
    width = _width(scene, joint_of_subject(line.subject))
    step = 0.5 * width / _TRIED
    beside = [_of_order(line, line.variant + away) for away in (-step, 0.0, step)]
    before, here, after = _gain(_without((line,), selected, beside)).tolist()
    reach = 0.5 * (beside[2].variant - beside[0].variant)
    curvature = (2.0 * here - before - after) / reach**2
    return float(np.sqrt(2.0 / curvature)) if curvature > 0.0 else width
