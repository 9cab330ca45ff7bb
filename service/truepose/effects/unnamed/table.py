"""The table of cells that have no trade name: a further kind is one more row in one of its parts."""

from truepose.effects.installed import INSTALLED
from truepose.effects.unnamed import (
    over_angles,
    over_load,
    over_moves,
    over_sight,
    over_temperature,
    over_time,
)
from truepose.effects.unnamed.kinds import Kind

OWN: dict[str, Kind] = {
    kind.name: kind
    for part in (over_time, over_temperature, over_angles, over_load, over_moves, over_sight)
    for kind in part.KINDS
}
KINDS: dict[str, Kind] = OWN | {name: kind for name, kind in INSTALLED.kinds.items() if name not in OWN}
