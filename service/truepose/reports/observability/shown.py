"""The observability of a model as templates have it."""

from collections.abc import Sequence

from truepose.domain.results.identification import NotIdentifiable, Parameter
from truepose.reports.observability.determined import determined, observability_sentence
from truepose.reports.observability.figure import observability_figure
from truepose.words.catalogue import Catalogue


def observability_context(
    parameters: Sequence[Parameter], left_out: Sequence[NotIdentifiable], words: Catalogue
) -> dict[str, object]:
    """Return what the template `observability.html` fills in."""
    found = determined(parameters)
    return {
        "observability": observability_figure(found, words),
        "observability_seen": observability_sentence(found, left_out),
    }
