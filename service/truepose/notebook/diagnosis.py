"""Diagnosis in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from truepose.diagnosis.diagnose import diagnose as diagnose_campaign
from truepose.domain import diagnosis as domain
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import NominalAndIdentified
from truepose.exchange.json_text import Json
from truepose.exchange.results.diagnosis import FindingDocument, diagnosis_document
from truepose.messages.catalogue import english
from truepose.notebook import display
from truepose.notebook.campaign import Campaign, campaign_given
from truepose.notebook.display import STATISTICS, change_of, count_text, finding_texts, frame, rows_of
from truepose.notebook.inputs import Progress, effects_given, on_one_thread
from truepose.notebook.model import Model
from truepose.validation.outcome import outcome_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

_COLUMNS = (
    "effect", "subject", "amplitude", "unit", "amplitude_standard_uncertainty", "p_value", "confidence",
    "where", "over", "shape", "sentence",
)  # fmt: skip


@dataclass(frozen=True, slots=True, repr=False)
class Diagnosis:
    """What the model of a robot gets wrong, why, and how much better the extended one is.

    Attributes
    ----------
    answer : truepose.domain.diagnosis.Diagnosis
        Everything that was found; `answer.findings` with their curves, the most important first.

    Examples
    --------
    >>> import truepose as tp
    >>> diagnosis = tp.diagnose(tp.read_campaign("docs/examples/campaign"))
    >>> diagnosis.verdict, len(diagnosis.answer.findings)
    ('consistent', 0)
    >>> diagnosis.document["held_out"]
    'validation'
    """

    answer: domain.Diagnosis

    @property
    def verdict(self) -> str:
        """What the data say: `consistent`, `explained`, `partly_explained`, `unexplained`."""
        return self.answer.verdict.value

    @property
    def message(self) -> str:
        """The answer in one sentence."""
        return english(self.answer.message)

    @property
    def model(self) -> Model | None:
        """The model extended by what was found; None where nothing could be fitted."""
        return None if self.answer.model is None else Model(self.answer.model)

    @property
    def document(self) -> dict[str, Json]:
        """What `truepose diagnose --json` prints."""
        return diagnosis_document(self.answer)

    def to_frame(self) -> DataFrame:
        """Return one row per finding, small ones last: effect, subject, amplitude in its unit, and so on.

        `rms_before_mm` and `rms_after_mm` are of held-out readings, without and with that finding. Raises
        MissingExtraError where pandas is not installed.
        """
        return frame([_row(finding) for finding in self.answer.all_findings])

    def plot(self, finding: int | None = None) -> Figure | None:
        """Return the curve of a finding in the residuals, or without a number the errors before and after.

        Parameters
        ----------
        finding : int, optional
            Its number, from 1 as they are listed.

        Returns
        -------
        matplotlib.figure.Figure or None
            None where there is nothing to draw: a finding without a curve, or no held-out reading.

        Raises
        ------
        ConfigurationError
            There is no finding of that number.
        """
        return self._errors() if finding is None else self._curve(finding)

    def _errors(self) -> Figure | None:
        from truepose.reports.figures.histograms import plain_comparison

        errors, after = self.answer.errors, self.answer.after
        if errors is None or after is None or not len(errors.config):
            return None
        norms = (np.linalg.norm(mm, axis=1) for mm in (errors.before_mm, errors.after_mm))
        before_mm, after_mm = (mm[np.isfinite(mm)] for mm in norms)
        return plain_comparison(before_mm, after_mm, after.noise_mm)

    def _curve(self, number: int) -> Figure | None:
        from truepose.reports.figures.residuals import plain_residual_curve

        findings = self.answer.all_findings
        if not 1 <= number <= len(findings):
            raise ConfigurationError(
                f"There is no finding {number}: the diagnosis has {count_text(len(findings), 'finding')}."
            )
        curve = findings[number - 1].curve
        return None if curve is None else plain_residual_curve(curve)

    def __repr__(self) -> str:
        before, after = self.answer.before, self.answer.after
        judged = f"; held-out {change_of(before, after)}" if before is not None and after is not None else ""
        found = count_text(len(self.answer.findings), "finding")
        named = ", ".join(f"{f.effect} of {f.subject}" for f in self.answer.findings[:3])
        more = ", ..." if len(self.answer.findings) > 3 else ""
        listed = f" ({named}{more})" if named else ""
        return f"Diagnosis of {self.answer.robot}: {self.verdict}, {found}{listed}{judged}"

    def _repr_html_(self) -> str:
        before, after = self.answer.before, self.answer.after
        pair = None if before is None or after is None else NominalAndIdentified(before, after)
        errors = [] if pair is None else rows_of("held out", "before", "after", pair)
        head = ("", "finding", "confidence", "amplitude", "RMS before, mm", "after")
        rest = english(self.answer.remaining.sentence)
        left = () if rest in self.message else (rest,)
        findings = [finding_texts(number, f) for number, f in enumerate(self.answer.all_findings, start=1)]
        return display.page(
            display.paragraphs((english(outcome_of(self.answer)), self.message)),
            display.table("Findings", head, findings, numbers_from=3) if findings else display.paragraphs(()),
            display.table(
                f"{self.answer.quantity.capitalize()} errors, mm", STATISTICS, errors, numbers_from=2
            ),
            display.paragraphs(left),
        )


def _row(finding: domain.Finding) -> dict[str, object]:
    told = FindingDocument.of(finding).printed()
    gain = ("rms_before_mm", "rms_after_mm")
    return {name: told[name] for name in _COLUMNS} | {
        name: getattr(finding.gain, name, None) for name in gain
    }


@on_one_thread
def diagnose(
    campaign: Campaign | str | Path, effects: Sequence[str] | None = None, progress: Progress | None = None
) -> Diagnosis:
    """Say what the model of a campaign's robot gets wrong, name the causes, measure the gain.

    Parameters
    ----------
    campaign : Campaign or path
        A path is read first, as by `read_campaign`.
    effects : sequence of str, optional
        The model to start from; none of these is a finding. By default base, tool as far as unknown,
        geometry, and compliance where masses or torques are known.
    progress : callable, optional
        Told the fraction done (0 to 1) and what is being done.

    Returns
    -------
    Diagnosis

    Raises
    ------
    UnknownEffectError
        There is no effect of that name; the sentence lists those that there are.
    ConfigurationError
        An effect is named twice or does not go with the campaign, or what is given is not a campaign.
    InputFileError
        The folder or zip cannot be read, with file, line and column.

    Examples
    --------
    >>> import truepose as tp
    >>> campaign = tp.read_campaign("docs/examples/campaign")
    >>> tp.diagnose(campaign)  # or at once tp.diagnose("docs/examples/campaign")
    Diagnosis of ABB IRB 120, simulated: consistent, no finding; held-out RMS 0.0... -> 0.0... mm
    """
    data = campaign_given(campaign).data
    return Diagnosis(diagnose_campaign(data, effects_given(effects), progress))
