"""What a cell is made of, as a scenario file states it; every size has the value of the shipped cells."""

from dataclasses import dataclass, field, replace

from truepose_simulators.cell.drawn_effects import CurveSizes, EverydaySizes
from truepose_simulators.cell.environment import AirSetup
from truepose_simulators.cell.fixture import HandsSetup
from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.kinds import check_nest
from truepose_simulators.faults.times import Fault
from truepose_simulators.instruments.accuracy import BallbarSetup, CameraSetup, ProbeSetup, TrackerSetup
from truepose_simulators.instruments.gauges.loop import LoopSetup
from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.physics.true_robot import PlantSizes
from truepose_simulators.scenarios.table import require_at_least_0

_PROTOCOLS = ("open_abb", "rws", "mappdk", "rmi", "ur_rtde", "kuka_variable_proxy")
_HIGHEST_PORT = 65_535


@dataclass(frozen=True, slots=True)
class ConfiguredMotion:
    """A rigid motion that is stated instead of drawn."""

    translation_mm: Vector = (0.0, 0.0, 0.0)
    rotation_rad: Vector = (0.0, 0.0, 0.0)  # rotation vector


@dataclass(frozen=True, slots=True)
class ConfiguredLink:
    """Errors of one link that are stated instead of drawn; seat axes of its joint."""

    joint: int
    translation_mm: Vector = (0.0, 0.0, 0.0)
    rotation_rad: Vector = (0.0, 0.0, 0.0)
    compliance_rad_per_n_mm: float | None = None  # absent: drawn


@dataclass(frozen=True, slots=True)
class ToolSetup:
    """The artefact on the flange: three nests and their reflectors, flange frame."""

    nests_mm: tuple[Vector, ...] = ((0.0, 0.0, 125.0), (75.0, 93.675, 215.0), (150.0, 0.0, 125.0))
    facing: tuple[Vector, ...] = ((-0.80, -0.45, 0.40), (-0.20, 0.70, 0.70), (0.85, -0.40, 0.35))
    acceptance_deg: float = 30.0  # how far off its axis a reflector still returns the beam
    nest_u_mm: float = 0.002  # certificate: true nests are off by this, one sigma per axis
    mass_kg: float = 2.7
    centre_of_gravity_mm: Vector = (50.0, 25.0, 100.0)

    def __post_init__(self) -> None:
        if len(self.facing) != len(self.nests_mm):
            raise ScenarioError('keys "nests_mm" and "facing" must have the same number of entries')
        if not all(any(axis) for axis in self.facing):
            raise ScenarioError('key "facing" must not contain a zero vector')
        require_at_least_0(self, "nest_u_mm", "mass_kg")


@dataclass(frozen=True, slots=True)
class TableSetup:
    """Fixed nests on the table, world frame."""

    fixed_nests_mm: tuple[Vector, ...] = ((600.0, -500.0, 0.0), (600.0, 500.0, 0.0), (-350.0, 500.0, 0.0))
    nest_u_mm: float = 0.002

    def __post_init__(self) -> None:
        require_at_least_0(self, "nest_u_mm")


@dataclass(frozen=True, slots=True)
class ArmSetup:
    """The arm and its controller."""

    scatter_mm: float = 0.0035  # repeatability per axis at the tool, drawn once per stop
    home_deg: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    refusal: str = "hang"  # what a client sees of a refused target: "hang" or "drop" (of the connection)
    states_gear_ratio: bool = True  # False: the papers of a campaign do not have it
    protocol: str = "open_abb"  # what the controller speaks, or another of the above
    egm_port: int | None = None  # of the computer to which an ABB streams its joints; absent: to none
    server: str = (
        "stock"  # what runs on the controller: the protocol's own program, or "truepose", that of ours
    )

    def __post_init__(self) -> None:
        require_at_least_0(self, "scatter_mm")
        if self.refusal not in {"hang", "drop"}:
            raise ScenarioError(f'key "refusal" must be "hang" or "drop", not "{self.refusal}"')
        if self.protocol not in _PROTOCOLS:
            known = " or ".join(f'"{protocol}"' for protocol in _PROTOCOLS)
            raise ScenarioError(f'key "protocol" must be {known}, not "{self.protocol}"')
        if self.egm_port is not None and not 1 <= self.egm_port <= _HIGHEST_PORT:
            raise ScenarioError(f'key "egm_port" must be 1 to {_HIGHEST_PORT}, not {self.egm_port}')
        if self.server not in {"stock", "truepose"}:
            raise ScenarioError(f'key "server" must be "stock" or "truepose", not "{self.server}"')


@dataclass(frozen=True, slots=True)
class Scenario:
    """One kind of cell; with a seed it becomes one cell."""

    name: str
    robot: str
    noise: bool = True  # False: no reading noise, no scatter, no two-face error
    errors: PlantSizes = field(default_factory=PlantSizes)
    base: ConfiguredMotion | None = None
    links: tuple[ConfiguredLink, ...] = ()
    arm: ArmSetup = field(default_factory=ArmSetup)
    tool: ToolSetup = field(default_factory=ToolSetup)
    table: TableSetup = field(default_factory=TableSetup)
    tracker: TrackerSetup = field(default_factory=TrackerSetup)
    probe: ProbeSetup | None = None  # absent: the tracker measures points only
    camera: CameraSetup | None = None  # absent: there is none
    ballbar: BallbarSetup = field(default_factory=BallbarSetup)
    loop: LoopSetup | None = None  # absent: no gauge but the ballbar
    hands: HandsSetup = field(default_factory=HandsSetup)
    air: AirSetup = field(default_factory=AirSetup)
    everyday: EverydaySizes | None = None  # absent: none of the many small effects of any robot
    curves: CurveSizes | None = None  # absent: no joint is off by a curve
    effects: tuple[PlantedChange, ...] = ()
    faults: tuple[Fault, ...] = ()

    def quiet(self) -> "Scenario":
        """Return the same robot without what an everyday one does over time: drift and warm-up."""
        if self.everyday is None:
            return self
        return replace(self, everyday=replace(self.everyday, over_time=False))

    def check_fault(self, fault: Fault) -> None:
        """Raise ScenarioError when a fault cannot happen in this cell."""
        check_nest(fault, tool_nests=len(self.tool.nests_mm), fixed_nests=len(self.table.fixed_nests_mm))
