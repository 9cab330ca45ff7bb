"""The table of cells that have no trade name: a further kind is one more row in one of its parts."""

from service.effects.unnamed import (
    over_angles,
    over_load,
    over_moves,
    over_sight,
    over_temperature,
    over_time,
)
from service.effects.unnamed.kinds import Kind

KINDS: dict[str, Kind] = {
    kind.name: kind
    for part in (over_time, over_temperature, over_angles, over_load, over_moves, over_sight)
    for kind in part.KINDS
}
