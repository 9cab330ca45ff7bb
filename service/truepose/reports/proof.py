"""A proof move: targets with and without correction, whether the correction is proved, and its report."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from markupsafe import Markup

from truepose.correction.proof import Proof, ProofErrors
from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import HeldOutErrors
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, message
from truepose.reports.cover_page import Front, OneFigure, error_bars
from truepose.reports.error_tables import Row, error_table, figures_row
from truepose.reports.figures.error_maps import ErrorMaps, error_maps
from truepose.reports.figures.histograms import comparison
from truepose.reports.report import Description, Report
from truepose.reports.rounding import format_fixed, millimetres
from truepose.reports.tables import Table
from truepose.validation.outcome import Outcome


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a proof comes to; each text is a key of the catalogue."""

    look: str  # as `shape.html` draws it
    word: str
    sentence: str
    next_step: str


_PROVED: Final = Verdict("consistent", "proof.proved", "proof.proved.sentence", "proof.proved.next")
_MORE_LEFT: Final = Verdict("partly_explained", "proof.more", "proof.more.sentence", "proof.more.next")
_BY_CHANCE: Final = Verdict("unexplained", "proof.chance", "proof.chance.sentence", "proof.chance.next")
_WORSE: Final = Verdict("unexplained", "proof.worse", "proof.worse.sentence", "proof.worse.next")


def proof_verdict(proof: Proof) -> Verdict:
    """Return what a proof comes to."""
    low, high = proof.gain_interval_95
    if proof.proved:
        return _PROVED
    if low > 1.0:
        return _MORE_LEFT
    return _WORSE if high < 1.0 else _BY_CHANCE


def proof_sentence(proof: Proof) -> Message:
    """Return the verdict with its figures."""
    low, high = proof.gain_interval_95
    return message(
        proof_verdict(proof).sentence,
        targets=proof.before.n,
        before=millimetres(proof.before.mean_mm),
        after=millimetres(proof.after.mean_mm),
        gain=proof.gain,
        low=low,
        high=high,
        promised=millimetres(proof.promised_mm),
    )


@dataclass(frozen=True, slots=True)
class ProofReport(Report):
    """Targets measured with and without the corrections of a model."""

    proof: Proof
    robot: str
    model_name: str
    warnings: tuple[Message, ...] = ()  # beside the proof's own

    def described(self, words: Catalogue) -> Description:
        """Return the verdict, both errors, their distribution, where they are, and every target."""
        proof = self.proof
        picture, beyond = _distribution(proof, words)
        shown = {
            "proof": proof,
            "model_name": self.model_name,
            "verdict": proof_verdict(proof),
            "sentence": proof_sentence(proof),
            "warnings": (*self.warnings, *proof.cautions),
            "errors": error_table(_error_rows(proof, words), words),
            "picture": picture,
            "beyond": beyond,
            "maps": _maps(proof.errors, words),
            "targets": target_table(proof.errors, words),
        }
        front = proof_front(proof, self.robot, words)
        return Description(front.title, self.robot, "proof.html", shown, front)


def proof_front(proof: Proof, robot: str, words: Catalogue) -> Front:
    """Return whether the corrections of a model make the robot better."""
    verdict = proof_verdict(proof)
    low, high = proof.gain_interval_95
    gain = OneFigure(
        words.say("proof.gain"),
        words.say("proof.gain.value", gain=proof.gain),
        words.say("proof.gain.interval", low=low, high=high),
    )
    return Front(
        title=words.say("proof.title", robot=robot),
        look=verdict.look,
        word=words.say(verdict.word),
        outcome=words.spoken(Outcome(proof.before, proof.after).sentence),
        sentence=words.spoken(proof_sentence(proof)),
        robot=robot,
        figure=gain,
        picture=error_bars(proof.before, proof.after, words, names=("before", "after")),
        caption=words.say("front.bars.proof"),
        rule=words.say(verdict.next_step),
    )


def _error_rows(proof: Proof, words: Catalogue) -> Iterator[Row]:
    """Yield each kind of error without and with correction."""
    without, corrected = words.say("proof.without"), words.say("proof.with")
    yield figures_row(words.say("errors.absolute"), without, proof.before)
    yield figures_row("", corrected, proof.after)
    if proof.before_relative is not None and proof.after_relative is not None:
        yield figures_row(words.say("errors.relative"), without, proof.before_relative)
        yield figures_row("", corrected, proof.after_relative)


def _distribution(proof: Proof, words: Catalogue) -> tuple[Markup, int]:
    errors = proof.errors
    return comparison(_norms(errors.before_mm), _norms(errors.after_mm), proof.after.noise_mm, words)


def _norms(errors_mm: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(errors_mm, axis=1))


def _maps(errors: ProofErrors, words: Catalogue) -> ErrorMaps | None:
    shown = HeldOutErrors(errors.config, errors.target_mm, errors.before_mm, errors.after_mm)
    return error_maps(shown, words)


def target_table(errors: ProofErrors, words: Catalogue) -> Table:
    """Return each target: its number, nest, place, and the sizes of its errors."""
    lengths = ("x", "y", "z", words.say("proof.without"), words.say("proof.with"))
    unit = words.units.conversion("mm").symbol
    heads = [
        words.say("proof.target"),
        words.say("circles.head.nest"),
        *(f"{one} [{unit}]" for one in lengths),
    ]
    sizes = np.stack([_norms(errors.before_mm), _norms(errors.after_mm)], axis=1)
    each = zip(errors.config, errors.nest, errors.target_mm, sizes, strict=True)
    return Table(heads, [_target_row(*one) for one in each])


def _target_row(number: int, nest: int, place: FloatArray, size: FloatArray) -> tuple[str, ...]:
    places = (format_fixed(float(x), 1, "mm") for x in place)
    return str((number + 1) // 2), str(nest), *places, *map(millimetres, size)
