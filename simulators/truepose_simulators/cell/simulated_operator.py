"""The simulated operator: what can be asked of their two hands, what they hold, and what cannot be done.

Every action is one word with details as further keys; one that is impossible is refused with a sentence, and
then nothing has changed.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np

from truepose_simulators.cell.environment import Air
from truepose_simulators.cell.fixture import ClampedCup, Fixture
from truepose_simulators.cell.planted import PlantedEffects
from truepose_simulators.cell.robot import JointMotion
from truepose_simulators.errors import HandsError, ScenarioError
from truepose_simulators.instruments.gauges.ballbar import Ball, Ballbar, BallbarSurroundings, BarSet, Span
from truepose_simulators.physics.rigid import FloatArray, pose_matrix
from truepose_simulators.scenarios.scenario import Scenario
from truepose_simulators.scenarios.table import read_table

Detail: TypeAlias = str | int | float | bool
_BALL_NEST = 1  # in which the setting ball sits
_IN_THE_WAY_MM = 60.0  # a nest so near to a cup leaves no place for a hand, nor for the ballbar's end


class OperatorWorkspace(Protocol):
    """The cell as its person sees it."""

    @property
    def now_s(self) -> float:
        """Present cell time [s]."""

    @property
    def robot_moves(self) -> bool:
        """Whether the arm is under way."""

    def nests_at_mm(self, time_s: float) -> FloatArray:
        """Where the tool nests are at a cell time, shape (nests, 3) [world]."""

    def nests_along_mm(self, motion: JointMotion) -> FloatArray:
        """Where the tool nests come along a motion, shape (m, nests, 3) [world]."""

    def nest_taken(self, nest: int) -> int:
        """Return the nest that is truly taken for `nest`; another one where labels are swapped."""

    def cup_taken(self, cup: int) -> int:
        """Return the cup that is truly taken for `cup` now; another one where the person errs."""

    def wild_mm(self) -> float:
        """By how much a connection made now is read wrong."""


@dataclass(frozen=True, slots=True)
class _Nothing:
    """Details of an action that needs none."""


@dataclass(frozen=True, slots=True)
class _Bars:
    bars: str  # "tool" or "base"


@dataclass(frozen=True, slots=True)
class _Leg:
    base: int
    tool: int


@dataclass(frozen=True, slots=True)
class _Side:
    artefact: str  # "tool" or "base"
    a: int
    b: int


@dataclass(frozen=True, slots=True)
class _Placement:
    placement: int
    # Of its mark in the world; none of them: the person knows where the mark is.
    x_mm: float | None = None
    y_mm: float | None = None
    z_mm: float | None = None
    rx_deg: float | None = None
    ry_deg: float | None = None
    rz_deg: float | None = None

    def mark(self) -> FloatArray | None:
        """Return the mark (4, 4) [world], None where none is stated; raises HandsError."""
        place, turn = (self.x_mm, self.y_mm, self.z_mm), (self.rx_deg, self.ry_deg, self.rz_deg)
        stated = [value for value in (*place, *turn) if value is not None]
        if not stated:
            return None
        if len(stated) < len(place + turn):
            raise HandsError("a mark is x_mm, y_mm, z_mm, rx_deg, ry_deg, rz_deg: state all of them or none")
        return pose_matrix(np.array(stated[:3]), np.radians(stated[3:]))


@dataclass(frozen=True, slots=True)
class _Cup:
    base_point: int


class Hands:
    """What the person has done so far, and does next."""

    def __init__(
        self, ballbar: Ballbar, fixture: Fixture, workplace: OperatorWorkspace, clamp_mm: float
    ) -> None:
        """Begin with the ballbar aside, no fixture and no setting ball; cups end up `clamp_mm` off."""
        self.accidents = 0  # motions that tore a magnet off its ball
        self.motions_attached = 0  # motions that began while the ballbar was on the tool
        self.ball_fitted = False
        self.ballbar = ballbar
        self.fixture = fixture
        self._workplace = workplace
        self._clamp_mm = clamp_mm
        self._known_to_fit = False
        self._actions: Mapping[str, tuple[type, Callable[[Any], None]]] = MappingProxyType({
            "calibrator": (_Bars, self._calibrator),
            "connect": (_Leg, self._connect),
            "side": (_Side, self._side),
            "detach": (_Nothing, self._detach),
            "hold": (_Nothing, self._hold),
            "place_base": (_Placement, self._place_base),
            "fit_ball": (_Nothing, self._fit_ball),
            "remove_ball": (_Nothing, self._remove_ball),
            "clamp": (_Cup, self._clamp),
            "pull_cable": (_Nothing, self._pull_cable),
            "plug_cable": (_Nothing, self._plug_cable),
            "switch_off": (_Nothing, self._switch_off),
            "switch_on": (_Nothing, self._switch_on),
        })

    def do(self, action: str, details: Mapping[str, Detail]) -> None:
        """Do one thing; raises HandsError with a sentence when it cannot be done."""
        if action not in self._actions:
            raise HandsError(f'there is no action "{action}"; known: {", ".join(self._actions)}')
        table, deed = self._actions[action]
        try:
            read: Any = read_table(table, details, f"action {action}")
        except ScenarioError as error:
            raise HandsError(str(error)) from error
        deed(read)

    def do_again(self, action: str, details: Mapping[str, Detail]) -> None:
        """Do once more what could be done at this time: whether the ballbar reaches is not asked again."""
        self._known_to_fit = True
        try:
            self.do(action, details)
        finally:
            self._known_to_fit = False

    def follow(self, motion: JointMotion) -> None:
        """See what becomes of the ballbar when the robot moves."""
        seat = self.ballbar.seat(motion.start_s)
        if not isinstance(seat, Span) or seat.second.kind != "nest" or motion.duration_s <= 0.0:
            return
        self.motions_attached += 1
        if seat.first.kind == "nest":
            return  # it travels with the tool
        cup = self.fixture.cup_mm(seat.first.number, motion.start_s)
        way = self._workplace.nests_along_mm(motion)[:, seat.second.number - 1]
        off_mm = np.abs(np.linalg.norm(way - cup, axis=1) - self.ballbar.nominal_mm)
        torn = np.flatnonzero(off_mm > self.ballbar.setup.travel_mm)
        if len(torn):
            self.accidents += 1
            share = float(torn[0]) / (len(way) - 1)
            self.ballbar.come_off(motion.start_s + share * motion.duration_s)

    def distance_mm(self, span: Span, time_s: float) -> float:
        """Return the true distance between two balls at a cell time; raises HandsError for a loose cup."""
        first, second = (self._place_mm(ball, time_s) for ball in (span.first, span.second))
        return float(np.linalg.norm(second - first))

    def _place_mm(self, ball: Ball, time_s: float) -> FloatArray:
        if ball.kind == "cup":
            return self.fixture.cup_mm(ball.number, time_s)
        nests = self._workplace.nests_at_mm(time_s)
        if not 1 <= ball.number <= len(nests):
            raise HandsError(f"there is no nest {ball.number} on the tool: it has {len(nests)}")
        place: FloatArray = nests[ball.number - 1]
        return place

    def _calibrator(self, wish: _Bars) -> None:
        self.ballbar.put_on_calibrator(_bar_set(wish.bars, "bars"), self._workplace.now_s)

    def _connect(self, leg: _Leg) -> None:
        self._need_bars("base", "a leg")
        cup = leg.base if self._known_to_fit else self._workplace.cup_taken(leg.base)
        self._put_between(Ball("cup", cup), Ball("nest", leg.tool))

    def _side(self, side: _Side) -> None:
        artefact = _bar_set(side.artefact, "artefact")
        if side.a == side.b:
            raise HandsError("a side needs two different points")
        self._need_bars(artefact, f"a side of the {artefact} triangle")
        kind: Literal["cup", "nest"] = "nest" if artefact == "tool" else "cup"
        if artefact == "base":
            self._need_nest_off((side.a, side.b), "the ballbar is put on the cup")
        self._put_between(Ball(kind, side.a), Ball(kind, side.b))

    def _detach(self, _: _Nothing) -> None:
        if self.ballbar.seat(self._workplace.now_s) is None:
            raise HandsError("the ballbar is not attached to anything")
        self.ballbar.take_off(self._workplace.now_s)

    def _hold(self, _: _Nothing) -> None:
        self.ballbar.take_in_hand()

    def _place_base(self, wish: _Placement) -> None:
        if wish.placement < 1:
            raise HandsError(f"placements count from 1, not {wish.placement}")
        self._need_ballbar_aside("the base fixture is moved")
        self.fixture.put_down(wish.placement, wish.mark())

    def _fit_ball(self, _: _Nothing) -> None:
        self._need_still("the setting ball is fitted")
        self._need_ballbar_aside("the setting ball is fitted")
        if self.ball_fitted:
            raise HandsError(f"the setting ball is already in nest {_BALL_NEST}")
        self.ball_fitted = True

    def _remove_ball(self, _: _Nothing) -> None:
        self._need_still("the setting ball is taken out")
        if not self.ball_fitted:
            raise HandsError("there is no setting ball in the tool")
        clamped = [cup.base_point for cup in self.fixture.cups if cup.placement == self.fixture.placement]
        self._need_nest_off(clamped, "the setting ball is taken out")
        self.ball_fitted = False

    def _clamp(self, cup: _Cup) -> None:
        self._need_still("a cup is clamped")
        if not self.ball_fitted:
            raise HandsError(f"there is nothing to clamp on: fit the setting ball in nest {_BALL_NEST} first")
        self._need_ballbar_aside("a cup is clamped")
        now_s = self._workplace.now_s
        ball = self._place_mm(Ball("nest", _BALL_NEST), now_s)
        self.fixture.clamp(cup.base_point, ball, self._clamp_mm, now_s)

    def _pull_cable(self, _: _Nothing) -> None:
        if not self.ballbar.plugged:
            raise HandsError("the ballbar cable is already unplugged")
        self.ballbar.plugged = False

    def _plug_cable(self, _: _Nothing) -> None:
        if self.ballbar.plugged:
            raise HandsError("the ballbar cable is already plugged in")
        self.ballbar.plugged = True

    def _switch_off(self, _: _Nothing) -> None:
        if not self.ballbar.switched_on:
            raise HandsError("the ballbar is already switched off")
        self.ballbar.switched_on = False

    def _switch_on(self, _: _Nothing) -> None:
        if self.ballbar.switched_on:
            raise HandsError("the ballbar is already switched on")
        self.ballbar.switched_on = True

    def _put_between(self, first: Ball, second: Ball) -> None:
        """Connect two balls, of a nest the one that is truly taken for it."""
        self._need_still("the ballbar is connected")
        now_s = self._workplace.now_s
        self._check_free(first, second)
        self._check_reach(Span(first, second), now_s)
        span = Span(self._taken(first), self._taken(second), self._workplace.wild_mm())
        self._check_reach(span, now_s)
        self.ballbar.put_between(span)

    def _taken(self, ball: Ball) -> Ball:
        return Ball("nest", self._workplace.nest_taken(ball.number)) if ball.kind == "nest" else ball

    def _check_free(self, *balls: Ball) -> None:
        if self.ball_fitted and Ball("nest", _BALL_NEST) in balls:
            raise HandsError(f"the setting ball is in nest {_BALL_NEST}: take it out first")

    def _check_reach(self, span: Span, time_s: float) -> None:
        if self._known_to_fit:
            return  # where everything is takes a hundred times longer to find than all the rest
        nominal, travel = self.ballbar.nominal_mm, self.ballbar.setup.travel_mm
        length = self.distance_mm(span, time_s)
        if abs(length - nominal) > travel:
            raise HandsError(
                f"the ballbar does not fit between {span.first} and {span.second}: they are {length:.1f} mm"
                f" apart, but it measures from {nominal - travel:g} to {nominal + travel:g} mm"
            )

    def _need_nest_off(self, base_points: Iterable[int], deed: str) -> None:
        """Refuse what the tool is in the way of while the robot still holds it over a cup."""
        if self._known_to_fit:
            return
        now_s = self._workplace.now_s
        nest = self._place_mm(Ball("nest", _BALL_NEST), now_s)
        for point in base_points:
            off_mm = float(np.linalg.norm(nest - self.fixture.cup_mm(point, now_s)))
            if off_mm < _IN_THE_WAY_MM:
                raise HandsError(
                    f"the robot holds nest {_BALL_NEST} {off_mm:.1f} mm from cup {point}: have it back off at"
                    f" least {_IN_THE_WAY_MM:g} mm before {deed}"
                )

    def _need_bars(self, bars: BarSet, purpose: str) -> None:
        if self.ballbar.bars != bars:
            raise HandsError(
                f"the ballbar does not have the bars for {purpose}: put it on the calibrator with the"
                f" {bars} bars first"
            )

    def _need_still(self, deed: str) -> None:
        if self._workplace.robot_moves:
            raise HandsError(f"the robot is moving: wait until it stands still before {deed}")

    def _need_ballbar_aside(self, deed: str) -> None:
        seat = self.ballbar.seat(self._workplace.now_s)
        if isinstance(seat, Span):
            raise HandsError(
                f"the ballbar is between {seat.first} and {seat.second}: detach it before {deed}"
            )


def _bar_set(text: str, key: str) -> BarSet:
    if text == "tool":
        return "tool"
    if text == "base":
        return "base"
    raise HandsError(f'key "{key}" must be "tool" or "base", not "{text}"')


def equip(
    scenario: Scenario,
    planted: Callable[[], PlantedEffects],
    air: Air,
    workplace: OperatorWorkspace,
    seed: np.random.SeedSequence,
) -> Hands:
    """Return the hands of the person of a cell; `planted` returns the effects as they are now."""
    handling, readings = (np.random.default_rng(part) for part in seed.spawn(2))
    noise = readings if scenario.noise else None

    def shifted_mm(cup: ClampedCup, time_s: float) -> FloatArray:
        when = np.array([cup.clamped_s]), np.array([time_s])
        shifted: FloatArray = planted().shifted_mm(cup.place_mm[np.newaxis], np.array([cup.placement]), *when)
        place: FloatArray = shifted[0]
        return place

    def distance_mm(span: Span, time_s: float) -> float:
        return hands.distance_mm(span, time_s)

    def error_mm(true_mm: float, initialisation: int, age_s: float, time_s: float) -> float:
        true, age, when = (np.array([value]) for value in (true_mm, age_s, time_s))
        return float(planted().length_errors_mm(true, np.array([initialisation]), age, when)[0])

    around = BallbarSurroundings(distance_mm, error_mm, lambda time_s: air.sensed_c(time_s, noise))
    ballbar = Ballbar(scenario.ballbar, around, noise, handling if scenario.noise else None)
    fixture = Fixture(scenario.hands, shifted_mm, handling)
    hands = Hands(ballbar, fixture, workplace, scenario.ballbar.clamp_mm if scenario.noise else 0.0)
    return hands
