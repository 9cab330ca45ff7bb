"""Every driver on bad lines: hostile bytes, hostile answers, faults of its link; other ones every night."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.demo.progress import RunProgress
from truepose.night.check import Check, at_most, none_of
from truepose.night.errors import UnknownCaseError
from truepose_drivers.contract import codec_fuzz, hostile, link_recovery
from truepose_drivers.contract.bench import NewBench, find_benches
from truepose_drivers.errors import ConfigurationError

_BYTES: Final = 2_000_000  # damaged answers to a codec alone, half a minute
_INPUTS: Final = 20_000  # ten to forty seconds of a driver
_LINK_FAULTS: Final = 500


@dataclass(frozen=True, slots=True)
class BadLine:
    """A driver and the bench that knows its device."""

    driver: str
    bench: NewBench
    seed: int
    inputs: int = _INPUTS
    to_codec: int = _BYTES

    @property
    def name(self) -> str:
        """As the night calls it."""
        return f"bad-line-{self.driver.replace('_', '-')}"

    @property
    def note(self) -> str:
        """What is tried."""
        return (
            f"{self.to_codec} damaged replies to its codec, {self.inputs} to its driver, and"
            f" {_LINK_FAULTS} link faults"
        )

    def run(self, folder: Path, progress: RunProgress) -> list[Check]:
        """Spoil and look; leaves what was wrong in `folder`."""
        read = codec_fuzz.CodecTally(self.driver)
        if codec_fuzz.has_codec(self.bench()):
            with progress.phase("damaged bytes"):
                read = codec_fuzz.tally(self.bench, self.to_codec, self.seed)
        with progress.phase("damaged replies"):
            harm = hostile.tally(self.bench, self.inputs, self.seed)
        with progress.phase("link faults"):
            link = link_recovery.tally(self.bench, _LINK_FAULTS, self.seed)
        examples = [*read.examples, *harm.examples, *link.examples]
        (folder / "examples.txt").write_text("\n".join([*examples, ""]), encoding="utf-8")
        return [*_of_codec(read), *_of_answers(harm), *_of_link(link, self.bench().lost_within_s)]


def bad_lines(seed: int, benches: tuple[str, ...]) -> list[BadLine]:
    """Return the case of every driver that has a bench; raises UnknownCaseError."""
    try:
        found = find_benches(benches, None)
    except ConfigurationError as error:
        raise UnknownCaseError(str(error)) from error
    return [BadLine(driver, bench, seed) for driver, bench in found.items()]


def _of_codec(found: codec_fuzz.CodecTally) -> list[Check]:
    return [_none("codec failures on damaged bytes", found.foreign, found.examples)]


def _of_answers(found: hostile.Tally) -> list[Check]:
    return [
        _none("detectable wrong values accepted", found.wrong_betrayable, found.examples),
        _none("exceptions other than driver errors", found.foreign, found.examples),
        _none("requests that hung", found.hung, found.examples),
        _none("out of step after two good replies", found.out_of_step, found.examples),
    ]


def _of_link(found: link_recovery.RecoveryTally, lost_within_s: float) -> list[Check]:
    return [
        at_most("longest time to report a lost link", max(found.lost_s, default=0.0), lost_within_s, "s", 2),
        at_most(
            "longest time to recover", max(found.back_s, default=0.0), link_recovery.BACK_WITHIN_S, "s", 2
        ),
        _none("stale values accepted", found.stale, found.examples),
        _none("links left open", found.left_open, found.examples),
    ]


def _none(figure: str, count: int, examples: list[str]) -> Check:
    """Return that something never happened; what is wrong is among the examples."""
    return none_of(figure, [*examples, ""][:1] * count)
