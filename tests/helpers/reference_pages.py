"""Reference pages that are written from the code: commands, effects and drivers.

`python -m tests.helpers.reference_pages` writes `docs/reference`; a test holds the pages to the code.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby, starmap
from pathlib import Path
from typing import Any, Final

import typer.main

from truepose.cli.program import application
from truepose.effects.registry import CAUSES, EFFECTS
from truepose.effects.unclassified.cause import Unnamed
from truepose_drivers.registry import load_registry

FOLDER: Final = Path(__file__).parents[2] / "docs" / "reference"

_COMMANDS_INTRODUCTION: Final = (
    "Arguments and required options; `truepose COMMAND --help` explains all options with an example. "
    'Exit status: 0 done, 1 the answer is "no", 2 unusable input, 3 a device or the service failed, '
    "130 interrupted."
)
_EFFECTS_INTRODUCTION: Final = (
    "The names that `--effects` takes. A diagnosis looks for those with an amplitude; [simulated cells]"
    "(../../simulators/truepose_simulators/README.md#effects) plant them."
)
_DRIVERS_INTRODUCTION: Final = (
    "The names that `driver` in a [cell file](../cell-file.md) takes. Each name links to what the driver "
    "needs and to what was never tried on hardware; other keys of its `[[device]]` are its options."
)


def pages() -> dict[str, str]:
    """Return the text of each page by its file name."""
    return {
        "commands.md": _page("Commands", _COMMANDS_INTRODUCTION, _commands()),
        "effects.md": _page("Effects", _EFFECTS_INTRODUCTION, _effects()),
        "drivers.md": _page("Drivers", _DRIVERS_INTRODUCTION, _drivers()),
    }


def _page(title: str, introduction: str, body: Iterable[str]) -> str:
    note = "<!-- Written by python -m tests.helpers.reference_pages -->"
    return "\n".join([f"# {title}", "", note, introduction, "", *body, ""])


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    yield _row(heads)
    yield "|" + "---|" * len(heads)
    yield from map(_row, rows)


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _commands() -> Iterator[str]:
    found: Mapping[str, Any] = typer.main.get_group(application()).commands
    steps = list(dict.fromkeys(command.rich_help_panel for command in found.values()))
    in_order = sorted(found.items(), key=lambda named: steps.index(named[1].rich_help_panel))
    for step, named in groupby(in_order, key=lambda named: named[1].rich_help_panel):
        yield from (f"## {step}", "", *_table(("command", "does"), starmap(_command_row, named)), "")


def _command_row(name: str, command: Any) -> tuple[str, str]:
    parts = ["|".join(getattr(command, "commands", ())), *(_usage(p) for p in command.params if _is_shown(p))]
    usage = " ".join(["truepose", name, *filter(None, parts)]).replace("|", "\\|")
    return f"`{usage}`", str(command.help).strip().splitlines()[0]


def _is_shown(parameter: Any) -> bool:
    return bool(parameter.required or parameter.param_type_name == "argument")


def _usage(parameter: Any) -> str:
    named = parameter.param_type_name == "option"
    shown = f"{parameter.opts[0]} {_value(parameter)}" if named else str(parameter.name).upper()
    return shown if parameter.required else f"[{shown}]"


def _value(option: Any) -> str:
    return str(option.opts[0]).removeprefix("--").upper()


def _effects() -> Iterator[str]:
    named = {name: effect for name, effect in EFFECTS.items() if not isinstance(effect, Unnamed)}
    rows = (_effect_row(name, effect) for name, effect in sorted(named.items()))
    return _table(("effect", "parameters", "amplitude"), rows)


def _effect_row(name: str, effect: Any) -> tuple[str, ...]:
    described = str(type(effect).__doc__).splitlines()[0].rstrip(".")
    return f"`{name}`", described, effect.signature.amplitude if name in CAUSES else ""


def _drivers() -> Iterator[str]:
    rows = (_driver_row(name, plugin) for name, plugin in sorted(load_registry().plugins.items()))
    return _table(("driver", "device", "options"), rows)


def _driver_row(name: str, plugin: Any) -> tuple[str, ...]:
    folder = plugin.open.__module__.split(".")[1]
    readme = f"../../drivers/truepose_drivers/{folder}/README.md"
    linked = f"[`{name}`]({readme})" if (FOLDER / readme).resolve().is_file() else f"`{name}`"
    kinds = " or ".join(kind.replace("_", " ") for kind in (plugin.kind, *plugin.also))
    return linked, kinds, ", ".join(f"`{option}`" for option in plugin.options)


if __name__ == "__main__":
    for name, text in pages().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
