"""Arms with effects that the model which is identified of them lacks."""

from dataclasses import replace

import numpy as np

from tests.helpers.identification.synthetic import configurations, measured, nominal_campaign
from truepose.domain.campaign import Stops
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.prediction import predict
from truepose.identification.problem.build import build

GAP_RAD = 3e-4  # 0.1 to 0.2 mm at the tool


MODEL = ("base", "geometry", "compliance")


def campaign(seed=0, n=80):
    """Stops that were approached from both sides."""
    plain = nominal_campaign(n, seed)
    ways = np.random.default_rng(seed).choice([-1, 1], (n, 6))
    stops = replace(plain.calibration.stops, direction=ways)
    return replace(plain, calibration=replace(plain.calibration, stops=stops))


def robot(seed=0, n=80, **lacking):
    """A campaign of an arm with effects that `MODEL` lacks, and the values of all its parameters."""
    asked, effects = campaign(seed, n), (*MODEL, "backlash", "joint_harmonics")
    structure = build(asked, effects).structure
    rng = np.random.default_rng((seed, 1))
    values = structure.prior_means + 0.2 * np.minimum(structure.prior_widths, 1.0) * rng.normal(
        size=len(structure.specs)
    )
    for k, name in enumerate(structure.names):
        if structure.owners[k] in ("backlash", "joint_harmonics"):
            values[k] = lacking.get(name, 0.0)
    return measured(asked, values, seed=seed, effects=effects)[0], structure, values


def errors_over_stated(read, structure, values, model, seed):
    """True errors of a model at targets where no one measured, over its stated uncertainty, (n, 3)."""
    n = 200
    joints = configurations(n, seed=1000 + seed)
    stops = Stops(np.arange(n), joints, direction=np.ones((n, 6), dtype=np.int64))
    nest = 1 + np.arange(n) % 3
    true = evaluate(structure, values, Targets(stops, nest)).position_mm
    predicted, uncertainty = predict(model, stops, nest)
    return (true - predicted) / uncertainty[:, None]
