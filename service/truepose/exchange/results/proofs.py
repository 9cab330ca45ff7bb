"""What a proof move says, as a document."""

from pydantic import Field

from truepose.correction.proof.verdict import Proof
from truepose.domain.results.identification import Statistics
from truepose.exchange.outgoing import Quantities, Quantity
from truepose.exchange.results.document_base import Document
from truepose.exchange.results.statistics import StatisticsDocument
from truepose.words.catalogue import english


class ProofErrorsDocument(Document):
    """From each target to where its nest was read, target by target; x y z in the world."""

    config: list[int] = Field(description="Of the uncorrected stop.")
    nest: list[int]
    target_mm: list[Quantities]
    before_mm: list[Quantities]
    after_mm: list[Quantities]


class ProofDocument(Document):
    """The same targets without and with correction, as they were measured."""

    targets: int = Field(examples=[30])
    before: StatisticsDocument = Field(
        description="Without correction: from the target to where the nest was read."
    )
    after: StatisticsDocument = Field(description="With correction.")
    before_relative: StatisticsDocument | None = Field(
        description="After the best rigid alignment of the targets; null of fewer than four, or on a line."
    )
    after_relative: StatisticsDocument | None
    gain: Quantity = Field(description="Mean error without over mean error with correction.", examples=[12.4])
    gain_interval_95: list[Quantity] = Field(min_length=2, max_length=2, examples=[[10.1, 15.2]])
    promised_mean_mm: Quantity = Field(description="Mean error that model, arm and readings let expect.")
    keeps_promise: bool
    proved: bool = Field(description="The correction helps beyond chance and keeps its promise.")
    foretold_share: Quantity = Field(
        description="How much of the errors that the model foretells was there without correction; 1: all.",
        examples=[0.98],
    )
    cautions: list[str] = Field(description="What explains a correction that does not help.")
    errors: ProofErrorsDocument


def proof_document(proof: Proof) -> ProofDocument:
    """Return the document of a proof."""
    errors = proof.errors
    return ProofDocument(
        targets=proof.before.n,
        before=StatisticsDocument.of(proof.before),
        after=StatisticsDocument.of(proof.after),
        before_relative=_of(proof.before_relative),
        after_relative=_of(proof.after_relative),
        gain=proof.gain,
        gain_interval_95=list(proof.gain_interval_95),
        promised_mean_mm=proof.promised_mm,
        keeps_promise=proof.keeps_promise,
        proved=proof.proved,
        foretold_share=proof.foretold_share,
        cautions=[english(caution) for caution in proof.cautions],
        errors=ProofErrorsDocument(
            config=errors.config.tolist(),
            nest=errors.nest.tolist(),
            target_mm=errors.target_mm.tolist(),
            before_mm=errors.before_mm.tolist(),
            after_mm=errors.after_mm.tolist(),
        ),
    )


def _of(found: Statistics | None) -> StatisticsDocument | None:
    return None if found is None else StatisticsDocument.of(found)
