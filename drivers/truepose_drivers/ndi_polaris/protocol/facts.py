"""What a camera says of itself: the lines of VER, and `Name=value` of GETINFO."""

from collections.abc import Mapping
from dataclasses import dataclass

from truepose_drivers.ndi_polaris.protocol.replies import Text

_MODEL, _SERIAL = "Features.Hardware.Model", "Features.Hardware.Serial Number"
_REVISION = " Rev "


@dataclass(frozen=True, slots=True)
class Identified:
    """Model, serial number and firmware; empty where the camera does not say."""

    model: str
    serial: str
    firmware: str


def facts(reply: Text) -> dict[str, str]:
    """Return what stands in lines of `name: value` (VER) or `name=value` (GETINFO)."""
    found: dict[str, str] = {}
    for line in reply.text.split("\n"):
        for mark in ("=", ":"):
            name, marked, value = line.partition(mark)
            if marked:
                found[name.strip()] = value.strip()
                break
    return found


def identified(version: Mapping[str, str], info: Mapping[str, str]) -> Identified:
    """Return who the camera is; what GETINFO says goes before what VER says."""
    model, _, revision = version.get("Freeze Tag", "").partition(_REVISION)
    return Identified(
        model=info.get(_MODEL, "") or model,
        serial=info.get(_SERIAL, "") or version.get("NDI S/N", ""),
        firmware=revision,
    )
