"""Validation in a notebook."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from markupsafe import Markup

from truepose.domain import identification as results
from truepose.domain import validation as domain
from truepose.domain.campaign import Readings
from truepose.domain.errors import ConfigurationError
from truepose.exchange.json_text import Json
from truepose.exchange.results.document import statistics_document
from truepose.exchange.results.validation import pose_test_document, validation_document
from truepose.identification import judge
from truepose.messages.catalogue import english
from truepose.notebook import display
from truepose.notebook.display import STATISTICS, change, count_text, frame, rows_of
from truepose.notebook.inputs import TableOrFile, on_one_thread, readings_given
from truepose.notebook.model import Model, model_given
from truepose.reports.pose_test import pose_test_table, withheld_sentences
from truepose.validation.cautions import pose_test_caution, validation_cautions
from truepose.validation.iso9283.pose_test import PoseTest, pose_test
from truepose.validation.outcome import outcome_of
from truepose.validation.validate import validate as validate_model

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, repr=False)
class Validation:
    """A model against readings that it was not made from.

    Attributes
    ----------
    answer : truepose.domain.validation.Validation
        Statistics of the errors [mm].
    remarks : tuple of str
        What was ignored in the table, and what the judgement does not contain.
    pose_test : truepose.validation.iso9283.pose_test.PoseTest or None
        Figures of ISO 9283, where they were asked for.

    Examples
    --------
    >>> import truepose as tp
    >>> campaign = tp.read_campaign("docs/examples/campaign")
    >>> judged = tp.validate(tp.identify(campaign).model, "docs/examples/campaign/validation.csv")
    >>> judged.passed
    True
    >>> judged.document["position"]["identified"]["n"]
    20
    """

    answer: domain.Validation
    model: results.Model
    readings: Readings
    remarks: tuple[str, ...]
    pose_test: PoseTest | None = None

    @property
    def passed(self) -> bool:
        """Whether every error is within the limit; without one, whether the model keeps what it claims."""
        return self.answer.passed

    @property
    def document(self) -> dict[str, Json]:
        """What `truepose validate --json` prints."""
        document = validation_document(self.answer)
        if self.pose_test is None:
            return document
        return document | {"iso9283": pose_test_document(self.pose_test)}

    def to_frame(self) -> DataFrame:
        """Return the statistics [mm], one row for each quantity and model.

        Raises MissingExtraError where pandas is not installed.
        """
        return frame([
            {"quantity": quantity, "model": model, **statistics_document(figures)}
            for quantity, pair in self._blocks()
            for model, figures in (("nominal", pair.nominal), ("identified", pair.identified))
        ])

    def plot(self, what: Literal["errors", "distances", "places"] = "errors") -> Figure:
        """Return errors of the nominal and the identified model as a figure of matplotlib.

        Parameters
        ----------
        what : str
            `errors`: a histogram of their sizes; `distances`: one of the distances between all pairs of
            points, with their signs; `places`: by distance from the measured zone and from axis 1.

        Raises
        ------
        ConfigurationError
            There are no pairs of points.
        """
        from truepose.reports.figures.curves import plain_place_errors
        from truepose.reports.figures.histograms import plain_distance_histogram, plain_histogram

        if what == "places" and self.answer.places is not None:
            return plain_place_errors(self.answer.places)
        if what == "distances":
            return plain_distance_histogram(self._distance_errors())
        shown = judge(self.model, self.readings, self.model.repeatability_mm)
        return plain_histogram(shown, self.answer.position.identified.noise_mm)

    def _distance_errors(self) -> domain.DistanceErrors:
        if self.answer.distance_errors is None:
            raise ConfigurationError(
                "There are no distance errors: at least two measured positions are needed, not lengths."
            )
        return self.answer.distance_errors

    def _blocks(self) -> Iterator[tuple[str, results.NominalAndIdentified]]:
        yield self.answer.quantity, self.answer.position
        if self.answer.relative is not None:
            yield "relative position", self.answer.relative
        if self.answer.distance is not None:
            yield "distance", self.answer.distance

    def _outcome(self) -> str:
        said = "passed" if self.passed else "not passed"
        limit = "" if self.answer.limit_mm is None else f" (limit {self.answer.limit_mm:g} mm)"
        judged = f"{self.model.robot.name} on {count_text(len(self.readings), 'reading')}"
        return f"Validation of {judged}: {said}{limit}"

    def __repr__(self) -> str:
        figures = "; ".join(f"{name} {change(pair)}" for name, pair in self._blocks())
        return f"{self._outcome()}; {figures}"

    def _repr_html_(self) -> str:
        rows = [row for name, pair in self._blocks() for row in rows_of(name, "nominal", "identified", pair)]
        return display.page(
            display.paragraphs((english(outcome_of(self.answer)), self._outcome())),
            display.table("Errors, mm", STATISTICS, rows, numbers_from=2),
            *self._pose_figures(),
            display.paragraphs(self.remarks),
        )

    def _pose_figures(self) -> Iterator[Markup]:
        if self.pose_test is None:
            return
        figures = pose_test_table(self.pose_test).of_columns(0, 2, 3, 6, 4, 5)
        yield display.table("ISO 9283:1998", figures.heads, figures.rows, numbers_from=4)
        yield display.paragraphs((
            *withheld_sentences(self.pose_test),
            english(pose_test_caution(self.pose_test)),
        ))


@on_one_thread
def validate(
    model: Model | str | Path,
    points: TableOrFile,
    limit_mm: float | None = None,
    *,
    iso9283: bool = False,
    rule: domain.DecisionRule = "guard band",
) -> Validation:
    """Judge a model on readings that it was not made from.

    Parameters
    ----------
    model : Model or path
        The path of a model file, which is read first.
    points : table or path
        n readings with the columns of `read_campaign`; a file is CSV.
    limit_mm : float, optional
        Largest error that passes. Without it the model passes when its mean error is neither above the
        nominal model's nor far above what it claims itself.
    iso9283 : bool, optional
        The rows hold cycles of poses: add the figures of ISO 9283.
    rule : str, optional
        Whether the decision about the limit counts the uncertainty of the readings: `guard band`, `simple`.

    Returns
    -------
    Validation

    Raises
    ------
    InputFileError
        The table cannot be used: with file and line, or row (from 0), and column.
    ConfigurationError
        The readings do not fit the model, the limit is no length, what is given is not a model, or the rows
        hold no cycles.

    Examples
    --------
    >>> import truepose as tp
    >>> model = tp.identify(tp.read_campaign("docs/examples/campaign")).model
    >>> tp.validate(model, "docs/examples/campaign/validation.csv", limit_mm=0.1)
    Validation of ABB IRB 120, simulated on 20 readings: passed (limit 0.1 mm); position RMS 0.7... -> 0.0...
    >>> tp.validate(model, {"config": [1], "q1_deg": [0.0]})
    Traceback (most recent call last):
    ...
    truepose.exchange.errors.MissingEntryError: points: column q2_deg is missing; it is required.
    """
    if limit_mm is not None and not 0.0 < limit_mm < math.inf:
        raise ConfigurationError(
            f"limit_mm, the largest acceptable error, must be greater than 0 mm (got {limit_mm:g} mm)."
        )
    data = model_given(model).data
    nests = [nest.nest for nest in data.nests]
    table = readings_given(points, "points").validation(data.robot.n_joints, nests, data.targets)
    answer = validate_model(data, table.readings, limit_mm=limit_mm, rule=rule)
    remarks = tuple(map(english, (*table.ignored, *validation_cautions(data, table.readings))))
    test = pose_test(data, table.readings) if iso9283 else None
    return Validation(answer, data, table.readings, remarks, test)
