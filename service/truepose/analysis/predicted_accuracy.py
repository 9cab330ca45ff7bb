"""What a cell or a session under way promises: the numerics, blocking for a second or two."""

from dataclasses import dataclass, replace

import numpy as np

from truepose.analysis.campaigns.tracker import MeasuredSession, assemble_campaign
from truepose.domain.campaign import sites
from truepose.domain.cell import Cell
from truepose.identification import identify
from truepose.planning.prediction.plan import PromisedPlan
from truepose.planning.prediction.robots_and_cells import Subject, of_campaign, of_cell
from truepose.planning.prediction.tracker import ExistingReadings, promised_session


@dataclass(frozen=True, slots=True)
class Promised:
    """A plan and what it is of."""

    subject: Subject
    plan: PromisedPlan


def promise_of_cell(cell: Cell, n: int | None) -> Promised:
    """Return what n configurations promise in a cell; None: as many as the knee of the curve says.

    Raises
    ------
    ConfigurationError, WorkSpaceError, TooFewCandidatesError
        The cell does not say where it may be measured, or does not offer that many configurations.
    """
    return _promised(of_cell(cell), n)


def promise_of_session(session: MeasuredSession, n: int | None) -> Promised:
    """Return what n further configurations promise a session, beside those that it has measured.

    Raises as `promise_of_cell`.
    """
    subject = of_cell(session.setup.cell)
    return _promised(_with_readings(subject, session) if session.points else subject, n)


def _with_readings(subject: Subject, session: MeasuredSession) -> Subject:
    """Return the subject with what was measured; what readings are worth is known once they make a model."""
    campaign = assemble_campaign(session)
    points, found = campaign.calibration, identify(campaign)
    model, judging = found.model, found.judging
    if points is None:
        return subject
    if model is not None:
        shown = of_campaign(campaign, model).knowns
        knowns = replace(subject.knowns, accuracy=shown.accuracy, discrepancy=shown.discrepancy)
        nominal_mm = None if judging is None else judging.nominal.mean_mm
        subject = replace(subject, knowns=knowns, nominal_mm=nominal_mm)
    # Places and not readings: a place that is measured again tells of noise, and of the arm nothing new.
    different = len(np.unique(sites(points.stops)))
    return replace(subject, measured=ExistingReadings(points.stops.joints_rad, points.nest, different))


def _promised(subject: Subject, n: int | None) -> Promised:
    plan = promised_session(subject.space, n, knowns=subject.knowns, measured=subject.measured)
    return Promised(subject, plan)
