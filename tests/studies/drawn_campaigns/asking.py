"""Asks everything that can be asked about a campaign, and judges what comes back.

An answer is a JSON document without NaN that has the keys of the interface; a refusal is an error of the
service's own tree with one sentence. Whatever else comes is a failure.
"""

import json
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tests.studies.drawn_campaigns.drawing import Drawn, drawn_campaign
from truepose.correction import Summary, correct, goals_of_joints, likely_mistake
from truepose.correction.reduced_models import controller_values
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.campaign import Campaign
from truepose.domain.errors import TrueposeError
from truepose.domain.identification import Model
from truepose.exchange.campaigns.folder import campaign_files, campaign_from
from truepose.exchange.models.file import model_from_text, model_text
from truepose.exchange.results.circles_and_spheres import circle_document, sphere_document
from truepose.exchange.results.corrections import correction_document
from truepose.exchange.results.diagnosis import diagnosis_document
from truepose.exchange.results.identification import identification_document
from truepose.exchange.results.plans import plan_document
from truepose.exchange.results.validation import validation_document
from truepose.identification import identify, predict
from truepose.planning.prediction.robots_and_cells import of_campaign
from truepose.planning.prediction.tracker import promised_session
from truepose.reports.plans import plan_sentences
from truepose.validation.cautions import prediction_cautions, validation_cautions
from truepose.validation.circle_test import circle_test
from truepose.validation.model_comparison import compare_models, largest_shift
from truepose.validation.sphere_test import sphere_test
from truepose.validation.validate import validate

_PLANNED_JOINTS = (
    6  # an arm of fewer shows a tracker hardly anything: its plans are refused after long searches
)
Ending = Literal["answer", "refusal", "failure"]
KEYS = {
    "identify": {
        "robot", "status", "message", "effects", "counts", "parameters", "not_identifiable", "outliers",
        "statistics", "chi2_per_dof",
    },
    "diagnose": {
        "robot", "verdict", "findings", "before", "after", "remaining", "next_measurements", "held_out",
    },
    "validate": {"position", "pass"},
    "correct": {"targets", "corrected", "statuses", "mean_u_mm", "largest_u_mm", "largest_move_deg"},
    "plan": {"configurations_deg", "predicted", "open", "observability", "minutes"},
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Asked:
    """One question about one campaign, and how it ended."""

    question: str
    ending: Ending
    told: str  # of a refusal its sentence, of a failure its traceback


class _NoAnswerError(Exception):
    """What came back is neither an answer nor a refusal as they have to be."""


def asked_about(seed: int) -> tuple[Drawn, list[Asked]]:
    """Draw the campaign of a seed and ask everything about it."""
    drawn = drawn_campaign(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return drawn, list(_questions(drawn))


def _questions(drawn: Drawn) -> Iterator[Asked]:
    read: list[Campaign] = []
    models: list[Model | None] = []
    yield _ended("read", lambda: read.append(_as_read(drawn.campaign)))
    if not read:
        return
    (campaign,) = read
    yield _ended("identify", lambda: models.append(_identified(campaign, drawn.effects)))
    yield _ended("diagnose", lambda: models.append(_diagnosed(campaign, drawn.effects)))
    yield from _tests(campaign)
    for model in filter(None, models):
        yield _ended("model", lambda model=model: _kept(model))
        yield _ended("predict", lambda model=model: _predicted(model, campaign))
        yield _ended("correct", lambda model=model: _corrected(model, campaign))
        yield _ended("controller", lambda model=model: controller_values(model))
        yield _ended("compare", lambda model=model: compare_models(model, model, campaign.readings))
        if campaign.held_out is not None:
            yield _ended("validate", lambda model=model: _validated(model, campaign))
    if models and models[0] is not None and campaign.robot.n_joints >= _PLANNED_JOINTS:
        yield _ended("plan", lambda: _planned(models[0], campaign))


def _tests(campaign: Campaign) -> Iterator[Asked]:
    """Ask of the readings alone what tests of joints and of lengths ask."""
    if campaign.calibration is not None:
        yield _ended("circles", lambda: circle_document(circle_test(campaign.calibration), "").printed())
    if campaign.legs is not None:
        yield _ended("sphere", lambda: sphere_document(sphere_test(campaign), "").printed())


def _ended(question: str, ask: Callable[[], object]) -> Asked:
    try:
        ask()
    except TrueposeError as error:
        sentence = str(error)
        good = sentence.strip() == sentence and "\n" not in sentence and sentence.endswith((".", "?"))
        return Asked(question, "refusal" if good else "failure", sentence)
    except Exception:
        return Asked(question, "failure", traceback.format_exc())
    return Asked(question, "answer", "")


def _as_read(campaign: Campaign) -> Campaign:
    files = {name: text.encode() for name, text in campaign_files(campaign).items()}
    return campaign_from(lambda name: files[name])


def _checked(question: str, document: object) -> None:
    text = json.dumps(document, allow_nan=False)
    missing = KEYS[question] - json.loads(text).keys()
    if missing:
        raise _NoAnswerError(f"{question} lacks {sorted(missing)}")


def _identified(campaign: Campaign, effects: tuple[str, ...] | None) -> Model | None:
    answer = identify(campaign, effects)
    _checked("identify", identification_document(answer, campaign.robot.name))
    return answer.model if answer.status.value == "converged" else None


def _diagnosed(campaign: Campaign, effects: tuple[str, ...] | None) -> Model | None:
    answer = diagnose(campaign, effects)
    _checked("diagnose", diagnosis_document(answer))
    return answer.model


def _kept(model: Model) -> None:
    model_from_text(model_text(model).encode(), "model.json")


def _predicted(model: Model, campaign: Campaign) -> None:
    stops = campaign.readings.stops
    position, uncertainty = predict(model, stops, np.full(len(stops), model.nests[0].nest))
    list(prediction_cautions(model, stops))
    if not np.isfinite(position).all() or not (uncertainty >= 0.0).all():
        raise _NoAnswerError("a prediction is not finite")


def _corrected(model: Model, campaign: Campaign) -> None:
    stops = campaign.readings.stops
    goals, summary = goals_of_joints(model, stops), Summary()
    summary.add(list(map(str, stops.config)), correct(model, goals))
    likely_mistake(model, goals, in_base=False)
    largest_shift(model)
    _checked("correct", correction_document(summary.totals))


def _validated(model: Model, campaign: Campaign) -> None:
    answer = validate(model, campaign.held_out, limit_mm=0.1)
    document = validation_document(answer)
    list(validation_cautions(model, campaign.held_out))
    document.setdefault("position", document.get("length"))
    _checked("validate", document)


def _planned(model: Model, campaign: Campaign) -> None:
    subject = of_campaign(campaign, model)
    plan = promised_session(
        subject.space, 4, knowns=subject.knowns, measured=subject.measured, n_candidates=30
    )
    document = plan_document(plan, campaign.robot.name, 1.0, list(plan_sentences(plan, 1.0)))
    _checked("plan", document.printed())
