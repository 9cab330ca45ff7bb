"""How far a model is from the truth, and how far the best possible one would be."""

from dataclasses import replace

import numpy as np

from tests.studies.camera.setups import RIGID, Setup
from tests.studies.simulated_arms import true_nests_mm
from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.identification import Model
from truepose.effects.frames.tool_certificate import NAME as CERTIFICATE
from truepose.effects.frames.tool_certificate import certificate_specs
from truepose.identification import predict
from truepose.identification.model.derivatives import position_jacobian
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.problem.build import automatic_effects, build
from truepose.planning.prediction.errors import mean_norms
from truepose.planning.tracker.plans import nominal_campaign
from truepose.planning.workspace.candidates import Candidates

_NESTS = 3
_TRACKER_MM = 0.0156  # per axis, in this work space


def true_mean_mm(here: Setup, model: Model, joints_rad: FloatArray) -> float:
    """Return the mean error of all three nests at configurations, shape (n, J)."""
    stops, nest = _rows(joints_rad)
    predicted, _ = predict(model, stops, nest)
    return float(
        np.linalg.norm(predicted - true_nests_mm(here.cell, joints_rad).reshape(-1, 3), axis=1).mean()
    )


def bound_mean_mm(here: Setup, read: Candidates, joints_rad: FloatArray) -> float:
    """Return the mean error that the best estimator is left with, on average over arms, artefacts, noise.

    The Cramer-Rao bound with the priors of the identification (Van Trees). A camera that fits a rigid body
    tells as much as one that read its nests one by one, and the definition of the artefact is off as if each
    of its nests were; both are put in so, other than the identification does. The world's frame is left out.
    """
    if here.camera is None:
        stops, nest = Stops(np.arange(len(read)), read.joints_rad), read.nest
        sigma, defined = np.hypot(_TRACKER_MM, here.cell.scenario.arm.scatter_mm), 0.0
    else:
        stops, nest = _rows(read.joints_rad)
        camera = here.cell.scenario.camera
        sigma, defined = camera.nest_mm / RIGID, camera.artefact_mm / RIGID
    told = _jacobian(here, read, stops, nest, defined) / sigma
    wanted = _jacobian(here, read, *_rows(joints_rad), 0.0)
    root = np.linalg.inv(np.linalg.cholesky(np.eye(len(told)) + np.einsum("pni,qni->pq", told, told)))
    left = np.einsum("pni,qp->niq", wanted, root[:, : len(wanted)])
    return float(np.mean(mean_norms(left, 0.0)))


def _jacobian(here: Setup, read: Candidates, stops: Stops, nest: IntArray, defined_mm: float) -> FloatArray:
    """Return how nests move per prior width of each parameter, the artefact's included, (P, n, 3)."""
    plain = replace(here.space, camera=None, nests=here.space.nests[:_NESTS])
    campaign = nominal_campaign(plain, Candidates(read.joints_rad, np.ones_like(read.nest)))
    problem = build(campaign, automatic_effects(campaign))
    structure, start = problem.structure, problem.start
    if defined_mm:
        specs = certificate_specs(dict.fromkeys(range(1, _NESTS + 1), defined_mm))
        structure, start = structure.extended(CERTIFICATE, specs), np.append(start, np.zeros(len(specs)))
    state = evaluate(structure, start, Targets(stops, nest))
    return position_jacobian(state) * structure.prior_widths[:, None, None]


def _rows(joints_rad: FloatArray) -> tuple[Stops, IntArray]:
    n = len(joints_rad)
    return Stops(np.arange(n * _NESTS), np.repeat(joints_rad, _NESTS, axis=0)), np.tile([1, 2, 3], n)
