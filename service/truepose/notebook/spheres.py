"""The ballbar sphere test in a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from truepose.domain.campaign import Campaign as CampaignData
from truepose.domain.errors import ConfigurationError
from truepose.exchange.json_text import Json
from truepose.exchange.results.circles_and_spheres import sphere_document
from truepose.messages.catalogue import IN_ENGLISH, english
from truepose.notebook import display
from truepose.notebook.campaign import Campaign, campaign_given
from truepose.notebook.display import count_text, frame
from truepose.notebook.inputs import on_one_thread
from truepose.notebook.model import Model, model_given
from truepose.reports.spheres import SphereReport, sphere_table, sphere_test_sentences
from truepose.reports.traceability import ReportConditions
from truepose.validation.sphere_test import NOMINAL, SphereTest, sphere_test

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, repr=False)
class SphereErrors:
    """What an arm errs by on the spheres of a ballbar.

    Attributes
    ----------
    answer : truepose.validation.sphere_test.SphereTest
        Errors and figures [mm], for each ball, model and centre.

    Examples
    --------
    >>> import numpy as np, truepose as tp
    >>> rng = np.random.default_rng(0)
    >>> lengths = {"placement": 1, "config": np.arange(20), "joints_rad": rng.uniform(-1.0, 1.0, (20, 6))}
    >>> lengths |= {"base_point": 1, "tool_point": 1, "length_mm": rng.uniform(200, 400, 20), "u_mm": 0.002}
    >>> wild = tp.read_campaign(lengths, robot="abb-irb-120", nests_mm=[(0.0, 0.0, 125.0)])
    >>> tp.sphere(wild).answer.is_complete
    False
    """

    answer: SphereTest
    campaign: CampaignData

    @property
    def document(self) -> dict[str, Json]:
        """What `truepose sphere --json` prints."""
        return sphere_document(self.answer, self.campaign.robot.name).printed()

    def to_frame(self) -> DataFrame:
        """Return the figures [mm], one row per ball, nest, model and centre.

        Raises MissingExtraError where pandas is not installed.
        """
        return frame([
            {
                "placement": sphere.placement,
                "base_point": sphere.base_point,
                "nest": nest,
                "model": one.model,
                "centre": "best" if one.errors.centre.is_fitted else "taught",
                "n": figures.n,
                "mean_mm": figures.mean_mm.value,
                "sd_mm": figures.sd_mm.value,
                "max_mm": figures.max_mm.value,
                "range_mm": figures.range_mm.value,
            }
            for sphere in self.answer.spheres
            for one in sphere.models
            for nest, figures in one.by_nest
        ])

    def report(self, file: str | Path) -> None:
        """Write the report, as `truepose sphere --report` does; raises UnwritableReportError."""
        stated = ReportConditions(simulated=bool(self.campaign.simulated))
        SphereReport(self.answer, self.campaign.robot.name, conditions=stated).write(Path(file))

    def __repr__(self) -> str:
        lengths = sum(len(sphere.config) for sphere in self.answer.spheres)
        rms = "; ".join(f"{name} RMS {value.value:.3f} mm" for name, value in self.answer.order)
        return f"Sphere test of {self.campaign.robot.name}: {count_text(lengths, 'length')}; {rms}"

    def _repr_html_(self) -> str:
        shown = sphere_table(self.answer, IN_ENGLISH)
        return display.page(
            display.table("Sphere test", shown.heads, shown.rows, numbers_from=shown.names),
            display.paragraphs(map(english, sphere_test_sentences(self.answer, IN_ENGLISH))),
        )


@on_one_thread
def sphere(
    campaign: Campaign | str | Path, models: Mapping[str, Model | str | Path] | None = None
) -> SphereErrors:
    """Say how true an arm holds a ballbar's length to one ball.

    Parameters
    ----------
    campaign : Campaign or path
        Lengths between a ball and the nests of the tool; its `setup` says where the arm held the ball.
    models : mapping of name to Model or path, optional
        Identified models of the robot with the same tool, by the names that they get in the answer.

    Returns
    -------
    SphereErrors

    Raises
    ------
    InputFileError
        The campaign cannot be read.
    ConfigurationError
        It holds no lengths, or they do not fit the ballbar or a model; a model is called `nominal`.

    Examples
    --------
    >>> import truepose as tp
    >>> tp.sphere("docs/examples/campaign")
    Traceback (most recent call last):
    ...
    truepose.domain.errors.ConfigurationError: A sphere test needs lengths between a ball and the tool; ...
    """
    named = {name: model_given(model).data for name, model in (models or {}).items()}
    if NOMINAL in named:
        raise ConfigurationError(f"The name {NOMINAL!r} is reserved for the nominal model; choose another.")
    data = campaign_given(campaign).data
    return SphereErrors(sphere_test(data, named), data)
