"""The report of a proof move: what a page shows of it."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from truepose.correction.proof.verdict import Proof, ProofErrors
from truepose.domain.arrays import FloatArray
from truepose.domain.results.diagnosis import HeldOutErrors
from truepose.domain.results.identification import Statistics
from truepose.domain.sentences import Sentence
from truepose.reports.figures.histograms.comparison import comparison
from truepose.reports.figures.maps.error_maps import ErrorMaps, error_maps
from truepose.reports.pages import rendered
from truepose.reports.proof.sentences import proof_sentence, proof_verdict
from truepose.reports.traceability.traced import Traced, traced_context
from truepose.reports.wording.rounding import fixed, millimetres
from truepose.words.catalogue import Catalogue


@dataclass(frozen=True, slots=True)
class ProofInput:
    """What a report of a proof is made from."""

    proof: Proof
    model_name: str
    traced: Traced
    warnings: tuple[Sentence, ...] = ()  # beside the proof's own


def proof_content(report: ProofInput, words: Catalogue) -> Markup:
    """Return the report of a proof without a frame, for a page that has one of its own."""
    proof = report.proof
    picture, beyond = _distribution(proof, words)
    return rendered(
        "proof_content.html",
        words=words,
        say=words.say,
        proof=proof,
        model_name=report.model_name,
        verdict=proof_verdict(proof),
        sentence=proof_sentence(proof),
        warnings=(*report.warnings, *proof.cautions),
        blocks=tuple(_blocks(proof)),
        picture=picture,
        beyond=beyond,
        maps=_maps(proof.errors, words),
        target_rows=tuple(_target_rows(proof.errors)),
        **traced_context(report.traced, words),
    )


def _blocks(proof: Proof) -> Iterator[tuple[str, Statistics, Statistics]]:
    """Yield the key of a kind of error, and its statistics without and with correction."""
    yield "errors.absolute", proof.before, proof.after
    if proof.before_relative is not None and proof.after_relative is not None:
        yield "errors.relative", proof.before_relative, proof.after_relative


def _distribution(proof: Proof, words: Catalogue) -> tuple[Markup, int]:
    errors = proof.errors
    return comparison(_norms(errors.before_mm), _norms(errors.after_mm), proof.after.noise_mm, words)


def _norms(errors_mm: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(errors_mm, axis=1))


def _maps(errors: ProofErrors, words: Catalogue) -> ErrorMaps | None:
    shown = HeldOutErrors(errors.config, errors.target_mm, errors.before_mm, errors.after_mm)
    return error_maps(shown, words)


def _target_rows(errors: ProofErrors) -> Iterator[tuple[str, ...]]:
    """Yield each target: its number, nest, place, and the sizes of its errors."""
    sizes = np.stack([_norms(errors.before_mm), _norms(errors.after_mm)], axis=1)
    for number, nest, place, size in zip(errors.config, errors.nest, errors.target_mm, sizes, strict=True):
        yield (
            str((number + 1) // 2),
            str(nest),
            *(fixed(float(x), 1, "mm") for x in place),
            *map(millimetres, size),
        )
