"""Identification in a notebook."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from truepose.domain import campaign as measured
from truepose.domain import identification as domain
from truepose.exchange.json_text import Json
from truepose.exchange.results.identification import identification_document
from truepose.identification import identify as identify_campaign
from truepose.messages.catalogue import english
from truepose.notebook import display
from truepose.notebook.campaign import Campaign, campaign_given
from truepose.notebook.display import STATISTICS, change, count_text, frame, parameter_table, rows_of
from truepose.notebook.fleets import Fleet
from truepose.notebook.inputs import Progress, effects_given, on_one_thread
from truepose.notebook.model import Model
from truepose.validation.outcome import outcome_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, repr=False)
class Identification:
    """The answer of an identification, whatever its status.

    Attributes
    ----------
    answer : truepose.domain.identification.Identification
        Everything that was found, in mm and rad.
    campaign : truepose.domain.campaign.Campaign
        What it was found from.

    Examples
    --------
    >>> import truepose as tp
    >>> answer = tp.identify(tp.read_campaign("docs/examples/campaign"))
    >>> answer.status
    'converged'
    >>> answer.document["counts"]["parameters"]
    31
    """

    answer: domain.Identification
    campaign: measured.Campaign

    @property
    def status(self) -> str:
        """How it ended.

        `converged`, `not_converged`, `too_few_data`, `wrong_nominal_model` or `outliers_dominate`.
        """
        return self.answer.status.value

    @property
    def message(self) -> str:
        """What to make of it, in words."""
        return english(self.answer.message)

    @property
    def model(self) -> Model | None:
        """The identified model; None where nothing could be fitted."""
        return None if self.answer.model is None else Model(self.answer.model)

    @property
    def document(self) -> dict[str, Json]:
        """What `truepose identify --json` prints."""
        return identification_document(self.answer, self.campaign.robot.name)

    def to_frame(self) -> DataFrame:
        """Return one row per parameter: name, effect, value, unit, standard uncertainty, prior width.

        Angles in deg, lengths in mm. Raises MissingExtraError where pandas is not installed.
        """
        return frame(self.document["parameters"])

    def plot(self) -> Figure | None:
        """Return the histogram of errors before and after, on the readings that judge the model.

        Held-out readings where there are any, else those of the calibration; None without a model. The figure
        is of matplotlib and belongs to no window: change and save it as any other.
        """
        from truepose.reports.figures.histograms import plain_histogram
        from truepose.reports.identification.judged_figures import judged, shown_noise_mm

        shown = judged(self.answer, self.campaign)
        return None if shown is None else plain_histogram(shown, shown_noise_mm(self.answer))

    def _blocks(self) -> Iterator[tuple[str, domain.NominalAndIdentified]]:
        """Yield the statistics that the model is judged by, the most telling first."""
        named = {
            "validation": self.answer.validation,
            "cross-validation": None if self.answer.validation else self.answer.cross_validation,
            "held-out, relative": self.answer.relative,
            "calibration": self.answer.calibration,
        }
        yield from ((name, pair) for name, pair in named.items() if pair is not None)

    def _configurations(self) -> str:
        return count_text(self.answer.counts.configurations, "configuration")

    @property
    def _title(self) -> str:
        return f"Identification of {self.campaign.robot.name}"

    def __repr__(self) -> str:
        counts = self.answer.counts
        judged = next((f"{name} {change(pair)}; " for name, pair in self._blocks()), "")
        sizes = (
            self._configurations(),
            count_text(counts.parameters, "parameter"),
            count_text(counts.outliers, "outlier"),
        )
        return f"{self._title}: {self.status}; {judged}{', '.join(sizes)}"

    def _repr_html_(self) -> str:
        errors = [
            row for name, pair in self._blocks() for row in rows_of(name, "nominal", "identified", pair)
        ]
        left_open = [
            f"Not distinguishable: {', '.join(group.parameters)}: {english(group.reason)}."
            for group in self.answer.not_identifiable
        ]
        return display.page(
            display.paragraphs((
                english(outcome_of(self.answer)),
                f"{self._title}: {self._configurations()}",
                self.message,
            )),
            display.table(
                f"{self.answer.quantity.capitalize()} errors, mm", STATISTICS, errors, numbers_from=2
            ),
            parameter_table(self.answer.parameters),
            display.paragraphs(left_open),
        )


@on_one_thread
def identify(
    campaign: Campaign | str | Path,
    effects: Sequence[str] | None = None,
    progress: Progress | None = None,
    *,
    fleet: Fleet | None = None,
) -> Identification:
    """Identify the robot of a campaign: by how much it differs from its nominal model.

    Parameters
    ----------
    campaign : Campaign or path
        A path is read first, as by `read_campaign`.
    effects : sequence of str, optional
        What may differ, by name: `["base", "tool", "geometry"]`. By default base, tool as far as unknown,
        geometry, and compliance where masses or torques are known.
    progress : callable, optional
        Told the fraction done (0 to 1) and what is being done.
    fleet : Fleet, optional
        Robots of the same type, as `tp.fleet_of` compared them: what they share is believed of this one, so
        that fewer readings do.

    Returns
    -------
    Identification
        Whatever the status.

    Raises
    ------
    UnknownEffectError
        There is no effect of that name; the sentence lists those that there are.
    ConfigurationError
        An effect is named twice or does not go with the campaign, what is given is no campaign, or the fleet
        has it already or is of another type.
    InputFileError
        The folder or zip cannot be read, with file, line and column.

    Examples
    --------
    >>> import truepose as tp
    >>> campaign = tp.read_campaign("docs/examples/campaign")
    >>> tp.identify(campaign)  # or at once tp.identify("docs/examples/campaign")
    Identification of ABB IRB 120, simulated: converged; validation RMS 0.7... -> 0.0... mm; 30 ...
    >>> tp.identify(campaign, ["base", "geometrie"])
    Traceback (most recent call last):
    ...
    truepose.domain.errors.UnknownEffectError: Unknown effect 'geometrie'; available effects: base, ...
    >>> tp.identify([[0.0, 10.0]])
    Traceback (most recent call last):
    ...
    truepose.domain.errors.ConfigurationError: A list is not a campaign: give ... tp.read_campaign...
    """
    data = campaign_given(campaign).data
    believed = None if fleet is None else fleet.believed_of(data)
    return Identification(identify_campaign(data, effects_given(effects), progress, believed=believed), data)
