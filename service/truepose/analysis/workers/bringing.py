"""Files that somebody brought, read in the worker; what computes is imported where it is needed."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

from truepose.storage.columns import pack
from truepose.storage.records import CampaignSummary

if TYPE_CHECKING:
    from truepose.exchange.brought.choices import Choices
    from truepose.exchange.brought.understood import Understood

_BESIDE: Final = "brought"  # in the archive of a campaign: the files as they came
_DESCRIPTION: Final = "campaign.json"
Report: TypeAlias = Callable[[float, str], None]


@dataclass(frozen=True, slots=True)
class BroughtCampaign:
    """A campaign of files that were brought, to be stored."""

    robot: str
    summary: CampaignSummary
    campaign: bytes
    archive: bytes


@dataclass(frozen=True, slots=True)
class BroughtRead:
    """What was understood of them, and the campaign that was asked for, if it can be made."""

    understood: "Understood"
    campaign: BroughtCampaign | None = None


@dataclass(frozen=True, slots=True)
class ReadBroughtTask:
    """Read files that somebody brought, as far as it goes."""

    files: tuple[tuple[str, str], ...]  # name and where it lies
    choices: "Choices"
    make: bool = False  # a campaign, not only what is shown

    def perform(self, report: Report) -> BroughtRead:
        """Return what was understood; raises TrueposeError."""
        from truepose.analysis.campaigns.summary import summary_of
        from truepose.exchange.brought.reading import read_brought
        from truepose.exchange.campaigns.zip_file import write_campaign_zip

        files = {name: Path(path).read_bytes() for name, path in self.files}
        found = read_brought(files, self.choices)
        if not self.make or found.campaign is None:
            return BroughtRead(found.understood)
        beside = {f"{_BESIDE}/{_safe(name)}": data for name, data in files.items()}
        made = BroughtCampaign(
            found.campaign.robot.name,
            summary_of(found.campaign),
            pack(found.campaign),
            write_campaign_zip(found.campaign, beside),
        )
        return BroughtRead(found.understood, made)


def _safe(path: str) -> str:
    """Return a path that stays in the archive; no second description, since an archive has one."""
    parts = [part for part in path.replace("\\", "/").split("/") if part not in {"", ".", ".."}]
    parts = [part.replace(":", "_") for part in parts] or ["file"]
    parts[-1] = f"as-it-came-{parts[-1]}" if parts[-1] == _DESCRIPTION else parts[-1]
    return "/".join(parts)
