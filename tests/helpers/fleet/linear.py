"""Fleets of a few made-up parameters, whose readings are linear in them; and their dense mixed model."""

from dataclasses import dataclass

import numpy as np

from truepose.effects.ports import ParameterSpec
from truepose.fleet.campaigns import Fleet, FleetCampaign, Information, fleet_of

SCALE = ParameterSpec("scale", "1", 0.0, 1e-4)


def told(jacobian, read, specs, owners=None):
    """What whitened readings (m,) with derivatives (p, m) tell."""
    return Information(
        tuple(specs),
        tuple(owners or ["geometry"] * len(specs)),
        jacobian @ jacobian.T,
        jacobian @ read,
        jacobian @ jacobian.T / len(read),
        len(read),
    )


@dataclass(frozen=True)
class Linear:
    """A fleet with everything that it was made from."""

    specs: tuple[ParameterSpec, ...]  # the scale last
    jacobians: list
    reads: list
    robot: list
    instrument: list
    day: list

    def fleet(self) -> Fleet:
        rows = zip(self.jacobians, self.reads, self.robot, self.instrument, self.day, strict=True)
        return fleet_of([
            FleetCampaign(f"robot {i}", f"tracker {k}", day, told(jacobian, read, self.specs))
            for jacobian, read, i, k, day in rows
        ])


def drawn(
    seed, *, robots=6, months=4, readings=12, robot=(0.5, 0.2, 0.3), day=0.2, trackers=2, drift=None
) -> Linear:
    """Draw a fleet of three parameters; sizes in stated widths.

    `drift` of (number of robot, month) or of a tracker's month is added to its parameters, shape (4,).
    """
    rng = np.random.default_rng(seed)
    specs = (
        ParameterSpec("theta_2", "rad", 1e-3, 5e-3),
        ParameterSpec("c_3", "rad/(N*mm)", 1e-7, 1e-7),
        ParameterSpec("gap_4", "rad", 0.0, 2e-3),
        SCALE,
    )
    widths = np.array([spec.prior_width for spec in specs])
    means = np.array([spec.prior_mean for spec in specs])
    common = rng.standard_normal(3)
    own = np.array(robot) * rng.standard_normal((robots, 3))
    instrument = 0.3 * rng.standard_normal(trackers)
    visit = {
        (k, m): instrument[k] + day * rng.standard_normal() for k in range(trackers) for m in range(months)
    }
    found = Linear(specs, [], [], [], [], [])
    for i in range(robots):
        for month in range(months):
            k = (i + month) % trackers
            at = np.append(common + own[i], visit[k, month])
            if drift is not None:
                at = at + drift(i, k, month)
            unit = 3.0 * rng.standard_normal((4, readings))
            noise = rng.standard_normal(readings)
            found.jacobians.append(unit / widths[:, None])
            found.reads.append((means + widths * at) @ (unit / widths[:, None]) + noise)
            for column, value in zip(
                (found.robot, found.instrument, found.day), (i, k, 30.0 * month), strict=True
            ):
                column.append(value)
    return found


class Dense:
    """The same model with one covariance of all readings."""

    def __init__(self, made: Linear) -> None:
        self.made = made
        self._widths = np.array([spec.prior_width for spec in made.specs])
        means = np.array([spec.prior_mean for spec in made.specs])
        self.unit = [jacobian * self._widths[:, None] for jacobian in made.jacobians]
        self.read = np.concatenate([
            read - means @ jacobian for jacobian, read in zip(made.jacobians, made.reads, strict=True)
        ])
        self.robots = np.concatenate([
            np.full(len(r), i) for r, i in zip(made.reads, made.robot, strict=True)
        ])
        self.trackers = np.concatenate([
            np.full(len(r), k) for r, k in zip(made.reads, made.instrument, strict=True)
        ])
        self.days = np.concatenate([np.full(len(r), d) for r, d in zip(made.reads, made.day, strict=True)])
        self.columns = np.concatenate(self.unit, axis=1)  # (4, m)

    def covariance(self, robot, day):
        same_robot = self.robots[:, None] == self.robots[None, :]
        same_tracker = self.trackers[:, None] == self.trackers[None, :]
        same_visit = same_tracker & (self.days[:, None] == self.days[None, :])
        total = np.eye(len(self.read))
        for p in range(3):
            total += np.outer(self.columns[p], self.columns[p]) * (1.0 + robot[p] * same_robot)
        scale = np.outer(self.columns[3], self.columns[3])
        return total + scale * (same_tracker + day * same_visit)

    def log_likelihood(self, robot, day):
        covariance = self.covariance(robot, day)
        return -0.5 * (np.linalg.slogdet(covariance)[1] + self.read @ np.linalg.solve(covariance, self.read))

    def common(self, robot, day):
        """Best prediction of what the robots have in common."""
        return self.columns[:3] @ np.linalg.solve(self.covariance(robot, day), self.read)

    def deviation(self, robot, day, number):
        """Best prediction of one robot's deviation."""
        cross = np.array(robot)[:, None] * self.columns[:3] * (self.robots == number)
        return cross @ np.linalg.solve(self.covariance(robot, day), self.read)
