"""What counts of a ballbar session, from its plan and its ledger."""

from collections.abc import Iterator, Sequence
from itertools import count

from truepose.analysis.campaigns.ballbar import RestPose, ValidCupSetup, ValidLength, ValidReadings, ValidSide
from truepose.domain.ballbar import ArrivalTaken, BallbarPlan, BallbarStep, StepKind
from truepose.domain.cell import BallbarKit
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.messages.catalogue import english
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.situation import Situation, situation


def counting(plan: BallbarPlan, kit: BallbarKit, entries: Sequence[LedgerEntry]) -> ValidReadings:
    """Return the readings of a session that count, in the order of its steps.

    Readings of a pose that a pre-calibration found exchanged do not count, those taken afterwards do.
    """
    found = situation(plan, kit, entries)
    legs = tuple(_legs(found))
    confused = _confused(entries)
    return ValidReadings(
        legs=tuple(kept for step_id, kept in legs if step_id not in confused),
        sides=tuple(_sides(found)),
        setups=tuple(_setups(found)),
        skipped=tuple(_skipped(found)),
        exchanged=tuple(sorted({kept.config for step_id, kept in legs if step_id in confused})),
        standing=_standing(found, entries),
    )


def _confused(entries: Sequence[LedgerEntry]) -> set[str]:
    """Return the legs whose last reading came before a pre-calibration found them exchanged."""
    confused: set[str] = set()
    measured: set[str] = set()
    for entry in entries:
        if entry.kind is EntryKind.MEASURED:
            measured.add(entry.step_id)
            # Read anew after the exchange was found, so it counts again.
            confused.discard(entry.step_id)
        if entry.precalibration is not None:
            # By the name of the pose: every attempt at it has steps of its own, and all that were read by
            # then are meant.
            poses = {f"pose-{config}" for config in entry.precalibration.exchanged}
            confused |= {step_id for step_id in measured if poses & set(step_id.split("/"))}
    return confused


def _standing(found: Situation, entries: Sequence[LedgerEntry]) -> RestPose | None:
    places = {step.id: step.placement for step in found.steps}
    for entry in reversed(entries):
        placement = places.get(entry.step_id)
        if entry.arrival is not None and placement is not None:
            return RestPose(placement, entry.arrival.commanded_rad)
    return None


class _StopNumbers:
    """Numbers of stops in a campaign: of a first attempt that of its pose, of each further one a free one."""

    def __init__(self, found: Situation) -> None:
        # Behind all numbers of the plan, since no arithmetic on a number tells attempts from poses (commit
        # 9080c258).
        self._free = count(1 + max((step.config or 0 for step in found.steps), default=0))
        self._given: dict[tuple[int, int], int] = {}

    def of(self, config: int, attempt: int) -> int:
        """Return the number of an attempt at a pose; the same one whenever it is asked for."""
        if attempt == 1:
            return config
        if (config, attempt) not in self._given:
            self._given[config, attempt] = next(self._free)
        return self._given[config, attempt]


def _legs(found: Situation) -> Iterator[tuple[str, ValidLength]]:
    stops = _StopNumbers(found)
    for step in found.steps:
        length = found.outcomes[step.id].length
        arrival = _arrival(found, step)
        if step.kind is not StepKind.CONNECT_LEG or length is None or arrival is None:
            continue
        if step.points is not None and step.config is not None and step.placement is not None:
            stop = stops.of(step.config, step.attempt)
            yield (
                step.id,
                ValidLength(step.placement, step.config, step.attempt, step.points, length, arrival, stop),
            )


def _sides(found: Situation) -> Iterator[ValidSide]:
    for step in found.steps:
        length = found.outcomes[step.id].length
        if step.kind is StepKind.MEASURE_SIDE and length is not None and step.points is not None:
            yield ValidSide(step.placement or 0, step.points, length)


def _setups(found: Situation) -> Iterator[ValidCupSetup]:
    for step in found.steps:
        arrival = _arrival(found, step)
        clamped = step.kind is StepKind.CLAMP_CUP and found.outcomes[step.id].kind == "confirmed"
        if clamped and arrival is not None and step.placement is not None and step.base_point is not None:
            yield ValidCupSetup(step.placement, step.base_point, arrival)


def _arrival(found: Situation, step: BallbarStep) -> ArrivalTaken | None:
    """Return where the arm stood at a step of a stop."""
    move = found.outcomes.get(step_ids.move(step_ids.group_of(step.id)))
    return None if move is None else move.arrival


def _skipped(found: Situation) -> Iterator[str]:
    """Say, once for each pose or step, what was left out and why."""
    told: set[str] = set()
    for step in found.steps:
        outcome = found.outcomes[step.id]
        what = step_ids.group_of(step.id) if step.config is not None else step.id
        if outcome.kind == "skipped" and what not in told:
            told.add(what)
            yield f"Skipped: {what}, {english(outcome.text) or 'no reason given'}."
