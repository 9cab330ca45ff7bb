"""Measures, identifies and validates industrial robots, and finds the causes of their errors.

`import truepose as tp` is the face for notebooks and programs. Names are loaded when they are first used.
"""

from typing import TYPE_CHECKING

from truepose.lazy_names import loader
from truepose.version import __version__

if TYPE_CHECKING:
    from truepose.domain.errors import TrueposeError
    from truepose.exchange.errors import InputFileError
    from truepose.notebook.campaign import Campaign, read_campaign
    from truepose.notebook.circles import CircleErrors, circles
    from truepose.notebook.correction import Corrections, correct
    from truepose.notebook.diagnosis import Diagnosis, diagnose
    from truepose.notebook.fleets import Fleet, fleet_of
    from truepose.notebook.identification import Identification, identify
    from truepose.notebook.model import Model, export, read_model
    from truepose.notebook.plan import Plan, plan
    from truepose.notebook.prediction import Predictions, predict
    from truepose.notebook.spheres import SphereErrors, sphere
    from truepose.notebook.validation import Validation, validate

__all__ = [
    "Campaign",
    "CircleErrors",
    "Corrections",
    "Diagnosis",
    "Fleet",
    "Identification",
    "InputFileError",
    "Model",
    "Plan",
    "Predictions",
    "SphereErrors",
    "TrueposeError",
    "Validation",
    "__version__",
    "circles",
    "correct",
    "diagnose",
    "export",
    "fleet_of",
    "identify",
    "plan",
    "predict",
    "read_campaign",
    "read_model",
    "sphere",
    "validate",
]

_HOMES = {
    "Campaign": "notebook.campaign",
    "CircleErrors": "notebook.circles",
    "Corrections": "notebook.correction",
    "Diagnosis": "notebook.diagnosis",
    "Fleet": "notebook.fleets",
    "Identification": "notebook.identification",
    "InputFileError": "exchange.errors",
    "Model": "notebook.model",
    "Plan": "notebook.plan",
    "Predictions": "notebook.prediction",
    "SphereErrors": "notebook.spheres",
    "TrueposeError": "domain.errors",
    "Validation": "notebook.validation",
    "circles": "notebook.circles",
    "correct": "notebook.correction",
    "diagnose": "notebook.diagnosis",
    "export": "notebook.model",
    "fleet_of": "notebook.fleets",
    "identify": "notebook.identification",
    "plan": "notebook.plan",
    "predict": "notebook.prediction",
    "read_campaign": "notebook.campaign",
    "read_model": "notebook.model",
    "sphere": "notebook.spheres",
    "validate": "notebook.validation",
}

if not TYPE_CHECKING:  # to a type checker every misspelt name would be one of ours
    __getattr__ = loader(__name__, _HOMES)


def __dir__() -> list[str]:
    return __all__
