"""The procedure of the thesis for a ballbar campaign: lengths become positions before anything is identified.

Six legs give the tool nests in the frame of the base cups by direct kinematics. That frame is laid on the
cups as the nominal robot placed them, by the planar motion that fits its triangle to the measured one. The
positions are then identified as a tracker's. Every error of cups and nominal robot is inside the frame, and
poses without six legs are lost: `identify` takes the lengths themselves; this stands beside it to compare.

Source: A. Nubiola, thesis, 2014, sections 3.3 and 4.1.
"""

from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.domain.campaign import Campaign, CupSetups, FixtureLengths, LegReadings, PointReadings
from truepose.domain.errors import ConfigurationError, UnderdeterminedError
from truepose.domain.identification import Anchor, Identification
from truepose.identification.identify import identify
from truepose.identification.observations.fixture import TOOL_PLACEMENT
from truepose.identification.problem.problem_setup import known_placement
from truepose.identification.verdict.relative_accuracy import judged_by_positions
from truepose.kinematics.chain import Chain, forward, nominal_values
from truepose.kinematics.frames import rigid_alignment
from truepose.kinematics.pose_device import Fixtures, Pose, base_triangle, fourth_cup, least_squares_pose

# Standard uncertainty of a coordinate of a nest over that of a length: table 3.1, root mean square over the
# coordinates of the three nests. Norms, which are larger by the root of three, stand beside them there.
_PROPAGATED = 1.54
_NESTS = 3


# Its 30 parameters: of axes 2 and 3, which are parallel, it drops one and adds no rotation.
THESIS_EFFECTS = ("base", "geometry_dhm", "compliance")


@dataclass(frozen=True, slots=True)
class Positions:
    """A ballbar campaign turned into one of positions.

    Attributes
    ----------
    campaign : Campaign
        With calibration instead of legs.
    cups : tuple of Anchor
        Where the procedure puts the base cups [mm, world frame].
    lost : tuple of int
        Configurations without a pose.
    """

    campaign: Campaign
    cups: tuple[Anchor, ...]
    lost: tuple[int, ...]


def positions_from_legs(campaign: Campaign) -> Positions:
    """Turn the legs of a campaign into positions of the tool nests, as the thesis does.

    Parameters
    ----------
    campaign : Campaign
        With legs, sides of triangles and set-ups of cups.

    Returns
    -------
    Positions
        Three readings a pose, in the world as the nominal robot placed the cups.

    Raises
    ------
    ConfigurationError
        A side of a triangle, a set-up or the place of a nest is missing, or no configuration has six legs.
    """
    legs = campaign.legs
    if legs is None or campaign.fixture is None or campaign.setup is None:
        raise ConfigurationError(
            "The procedure of the thesis needs the legs, fixture and setup of a ballbar campaign."
        )
    nests = _measured_nests(campaign, campaign.fixture)
    cups = {
        number: _placed_cups(campaign, campaign.fixture, campaign.setup, number)
        for number in distinct_values(legs.placement).tolist()
    }
    rows, places, lost = _direct_kinematics(campaign, legs, cups, nests)
    if not places:
        raise ConfigurationError(
            "No configuration of the campaign has six ballbar lengths that determine a pose."
        )
    anchors = tuple(
        Anchor(number, point, (float(x), float(y), float(z)))
        for number, centres in cups.items()
        for point, (x, y, z) in enumerate(centres, start=1)
    )
    calibration = _readings(legs, rows, np.concatenate(places))
    return Positions(replace(campaign, calibration=calibration, legs=None), anchors, tuple(lost))


def identify_as_thesis(campaign: Campaign) -> tuple[Identification, Positions]:
    """Identify a ballbar campaign as the thesis does, with its own parameters.

    Parameters
    ----------
    campaign : Campaign
        With legs, sides of triangles and set-ups of cups.

    Returns
    -------
    answer : Identification
        Judged by the campaign's positions, where it has any, tied by the procedure's own cups.
    positions : Positions

    Raises
    ------
    ConfigurationError
        As `positions_from_legs`.
    """
    positions = positions_from_legs(campaign)
    answer = identify(positions.campaign, THESIS_EFFECTS)
    if answer.model is None:
        return answer, positions
    # The model of positions knows no cups; those that the procedure laid down are the ones it was made from.
    judged = judged_by_positions(campaign, answer.model, positions.cups)
    return replace(answer, validation=None, positions=judged), positions


def _measured_nests(campaign: Campaign, fixture: FixtureLengths) -> FloatArray:
    """Return the nests as the measured triangle has them, laid on their certified places, shape (3, 3)."""
    certified = known_placement(campaign)
    if len(certified.nests_mm) != _NESTS or certified.nest_unknown.any():
        raise ConfigurationError(
            "The procedure of the thesis needs three tool nests with certified positions."
        )
    measured = base_triangle(*(_side(fixture, TOOL_PLACEMENT, *ends) for ends in ((1, 2), (2, 3), (1, 3))))
    rotation, translation = rigid_alignment(measured, certified.nests_mm)
    return np.asarray(measured @ rotation.T + translation)


def _side(fixture: FixtureLengths, placement: int, first: int, second: int) -> float:
    ends = np.sort(np.column_stack([fixture.point_a, fixture.point_b]), axis=1)
    here = (fixture.placement == placement) & (ends == (first, second)).all(axis=1)
    if not here.any():
        what = "of the tool" if placement == TOOL_PLACEMENT else f"of placement {placement}"
        raise ConfigurationError(
            f"Side {first}-{second} {what} was not measured, so the triangle is incomplete. Measure it."
        )
    # A side may have been measured more than once.
    return float(fixture.length_mm[here].mean())


def _placed_cups(campaign: Campaign, fixture: FixtureLengths, setup: CupSetups, placement: int) -> FloatArray:
    """Return the measured cups laid on where the nominal robot held the ball, shape (K, 3) [mm, world]."""
    here = np.flatnonzero(setup.placement == placement)
    here = here[np.argsort(setup.base_point[here])]
    points = setup.base_point[here].tolist()
    if points not in ([1, 2, 3], [1, 2, 3, 4]):
        raise ConfigurationError(
            f"Placement {placement} lacks the set-up of at least one base point; it has {points}."
        )
    cups = base_triangle(*(_side(fixture, placement, *ends) for ends in ((1, 2), (2, 3), (1, 3))))
    if len(points) > _NESTS:
        fourth = fourth_cup(cups, *(_side(fixture, placement, point, 4) for point in (1, 2, 3)))
        cups = np.vstack([cups, fourth])
    # Where the nominal robot held the ball: its errors go into the frame, which is what the thesis does.
    held = _nominal(campaign, setup.joints_rad[here]).points(
        np.broadcast_to(known_placement(campaign).nests_mm[0], (len(here), 3))
    )
    rotation, translation = rigid_alignment(cups, held)
    return np.asarray(cups @ rotation.T + translation)


def _nominal(campaign: Campaign, joints_rad: FloatArray) -> Chain:
    base = known_placement(campaign).base
    rotation, origin = (np.eye(3), np.zeros(3)) if base is None else base
    return forward(nominal_values(campaign.robot, joints_rad), rotation, origin)


def _direct_kinematics(
    campaign: Campaign, legs: LegReadings, cups: dict[int, FloatArray], nests_mm: FloatArray
) -> tuple[list[int], list[FloatArray], list[int]]:
    """Return a row of the legs and the three nests of each pose, and the configurations lost."""
    chain = _nominal(campaign, legs.stops.joints_rad)
    rows, places, lost = [], [], []
    for config in distinct_values(legs.stops.config).tolist():
        mine = np.flatnonzero(legs.stops.config == config)
        # Direct kinematics has several solutions; the commanded pose is near the right one.
        commanded = Pose(chain.rotation[-1][mine[0]], chain.origin[-1][mine[0]])
        fixtures = Fixtures(cups[int(legs.placement[mine[0]])], nests_mm)
        pairs = list(zip(legs.base_point[mine].tolist(), legs.nest[mine].tolist(), strict=True))
        covariance = np.diag(legs.standard_uncertainty_mm[mine] ** 2)
        try:
            found = least_squares_pose(fixtures, pairs, legs.length_mm[mine], covariance, commanded=commanded)
        # A pose without six legs is lost to this procedure, not filled in.
        except (ConfigurationError, UnderdeterminedError):
            lost.append(config)
            continue
        rows.append(int(mine[0]))
        places.append(found.pose.points(nests_mm))
    return rows, places, lost


def _readings(legs: LegReadings, rows: list[int], position_mm: FloatArray) -> PointReadings:
    """Return the three nests of each pose as readings of positions."""
    index = np.repeat(np.array(rows), _NESTS)
    nest: IntArray = np.tile(np.arange(1, _NESTS + 1), len(rows))
    uncertainty = _PROPAGATED * legs.standard_uncertainty_mm[index]
    return PointReadings(legs.stops.taken(index), nest, position_mm, uncertainty)
