"""The diagnosis of a campaign, from its readings to the answer: the one function that others call.

The order of the steps is that of decision 0015: fit the present model, screen every cause, select, refine
what was selected, and only then doubt it. It knows neither time nor files; drawing happens with fixed seeds,
so that the same readings get the same answer.
"""

from collections.abc import Callable
from dataclasses import replace

from truepose.diagnosis.answer import assemble_answer, unanswerable
from truepose.diagnosis.baseline_fit import Start, fit_baseline, scene_of, stands
from truepose.diagnosis.scatter import ScatterModel, with_scatter
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.diagnosis.screening.refinement import with_exact_moments, with_lines_between
from truepose.diagnosis.screening.selection import chosen, select
from truepose.diagnosis.sentences import with_scatter_told
from truepose.domain.campaign import Campaign
from truepose.domain.diagnosis import Diagnosis
from truepose.domain.last_moves import with_last_moves
from truepose.effects.causes import Candidate, Scene
from truepose.effects.readings.label_swap import NAME as LABEL_SWAP
from truepose.effects.registry import CAUSES
from truepose.identification.fit.robust import RobustFit
from truepose.identification.verdict.outliers import with_set_aside, within_reach
from truepose.messages.message import Text, message, together

Progress = Callable[[float, Text], None]

_FALSE_DEPENDENCES = 1  # that noise which is larger somewhere brought about, of 18 drawn campaigns in one


def diagnose(
    campaign: Campaign,
    effects: tuple[str, ...] | None = None,
    progress: Progress | None = None,
    *,
    without: tuple[str, ...] = (),
) -> Diagnosis:
    """Show what a model gets wrong, name the cause, extend the model and measure the gain.

    Parameters
    ----------
    campaign : Campaign
    effects : tuple of str, optional
        The model that it starts from; None takes base, tool as far as unknown, geometry, and compliance
        where masses or torques are known.
    progress : callable, optional
        Told the fraction done and what is being done.
    without : tuple of str
        Causes that are left out of the library, to see what is said when the true one is unknown.

    Returns
    -------
    Diagnosis

    Raises
    ------
    UnknownEffectError, ConfigurationError
        The request cannot be understood.
    """
    answer = _diagnosed(campaign, effects, progress or _silent, without)
    aside = campaign.set_aside
    if aside is None:
        return answer
    return replace(answer, message=together(answer.message, aside.sentence), set_aside=aside)


def _diagnosed(
    campaign: Campaign, effects: tuple[str, ...] | None, tell: Progress, without: tuple[str, ...]
) -> Diagnosis:
    """Diagnose, and again with readings as uncertain as they scatter where that depends on something."""
    answer, scatter = _as_stated(campaign, effects, tell, without)
    # What a model lacks is larger at some readings than at others too. Where much is left without a name, its
    # size says nothing of the noise.
    if scatter is None or len(answer.remaining.depends_on) > _FALSE_DEPENDENCES:
        return answer
    # Where readings far away scatter three times as much, they hide causes, and are taken for outliers.
    weighed, _ = _as_stated(with_scatter(campaign, scatter), effects, _silent, without)
    # Believed only where nothing is left with it: elsewhere the scatter may be what the model lacks.
    if weighed.noise is None or weighed.remaining.structure:
        return answer
    return with_scatter_told(weighed, scatter.told)


def _as_stated(
    campaign: Campaign, effects: tuple[str, ...] | None, tell: Progress, without: tuple[str, ...]
) -> tuple[Diagnosis, ScatterModel | None]:
    tell(0.02, message("job.doing.fitting"))
    # What no place of the arm gives leaves before anything is squared; left in, it would spoil the first fit.
    reached = within_reach(with_last_moves(campaign))
    start = fit_baseline(reached.campaign, effects, relabel=LABEL_SWAP not in without)
    if not isinstance(start, Start):
        return unanswerable(campaign, effects or (), start), None

    def propose(fit: RobustFit) -> tuple[Candidate, ...]:
        """Propose all causes again, for the model as it is fitted by now."""
        return propose_candidates(scene_of(start.problem, fit), without)

    tell(0.1, message("job.doing.screening"))
    # `first` is kept whole: the folds of the cross-validation choose anew from the same linearisation.
    first = chosen(pool_candidates(start.fit, propose(start.fit)))
    selected = select(
        first, propose, lambda share: tell(0.1 + 0.5 * share, message("job.doing.choosing_causes"))
    )
    # Lines before moments: a moment is placed by the readings that the final waves leave.
    selected = with_lines_between(start.fit, selected, propose, start.scene)
    selected = with_exact_moments(start.fit, selected, propose, start.scene)
    # Too many readings fell out of the start for any model to be trusted. Only a cause that brings them back
    # (a zero that jumped, say) makes an answer possible.
    if start.doubt and not (selected.picks and stands(start, selected.fit)):
        return unanswerable(campaign, effects or (), start.doubt), None
    tell(0.6, message("job.doing.judging_unseen"))
    answer, scatter = assemble_answer(start, first, selected, propose, without, tell)
    told = replace(
        answer,
        message=together(answer.message, reached.sentence),
        model=with_set_aside(answer.model, reached),
    )
    return told, scatter


def propose_candidates(scene: Scene, without: tuple[str, ...]) -> tuple[Candidate, ...]:
    """Return every way in which every known cause may be present in these data.

    Parameters
    ----------
    scene : Scene
        Of the fitted model; what it already holds is not proposed again.
    without : tuple of str
        Causes that are left out.

    Returns
    -------
    tuple of Candidate
        In the order of the registry. Causes that these data cannot show propose nothing.
    """
    return tuple(
        candidate
        for name, cause in CAUSES.items()
        if name not in without and cause.unseen(scene) is None
        for candidate in cause.candidates(scene)
    )


def _silent(_fraction: float, _doing: Text) -> None:
    return None
