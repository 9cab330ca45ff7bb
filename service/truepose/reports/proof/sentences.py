"""A proof move in one sentence, and what to do next."""

from dataclasses import dataclass
from typing import Final

from truepose.correction.proof.verdict import Proof
from truepose.domain.sentences import Sentence, said
from truepose.reports.wording.rounding import millimetres


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


def proof_sentence(proof: Proof) -> Sentence:
    """Return the verdict with its figures."""
    low, high = proof.gain_interval_95
    return said(
        proof_verdict(proof).sentence,
        targets=proof.before.n,
        before=millimetres(proof.before.mean_mm),
        after=millimetres(proof.after.mean_mm),
        gain=proof.gain,
        low=low,
        high=high,
        promised=millimetres(proof.promised_mm),
    )
