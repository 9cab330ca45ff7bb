"""What commands print, and how they end, on inputs that are always the same."""

import json
import shutil

from tests.helpers.checkout import CHECKOUT
from tests.helpers.commands import typed
from tests.recorded.transcript import Transcript, printed

_EXAMPLES = CHECKOUT / "docs" / "examples"
_TARGETS = "target,x_mm,y_mm,z_mm,qw,qx,qy,qz\n1,350,0,400,0,0,1,0\n2,350,0,2400,0,0,1,0\n"
_MODEL, _HELD_OUT = "model.json", "campaign/validation.csv"
# One after the other: later ones read what earlier ones wrote. One worker each: to start a second takes
# longer than all that it computes.
COMMANDS = [
    f"identify campaign --model-out {_MODEL} --json",
    "identify campaign --effects base,tool --json",
    "diagnose campaign --json",
    "identify nowhere --json",
    f"validate {_MODEL} {_HELD_OUT} --limit-mm 0.1 --json",
    f"validate {_MODEL} {_HELD_OUT} --limit-mm 0.001 --json",
    f"predict {_MODEL} {_HELD_OUT} --out predicted.csv",
    f"correct {_MODEL} targets.csv --out corrected.csv --json",
    f"export {_MODEL} --as urdf --out robot.urdf --json",
    f"export {_MODEL} --as dhm --out robot.csv --json",
    f"export {_MODEL} --as controller --out controller.json --json",
    "resample campaign --by noise --draws 20 --seed 1 --workers 1 --json",
    "plan campaign --n 8 --tries 2 --workers 1 --json",
    "reanalyse archive --out again --json",
    "import held-out.csv held-out.csv --robot abb-irb-120 --u-mm 0.02 --out imported",
    "people list --database sqlite:///shop.sqlite3",
    "verify shop.sqlite3 --json",
    "identify campaign --language de",
    "diagnose campaign --language fr",
    "identify campaign --set-aside 17=dérangée --set-aside 5/1=bousculée --person Ada --language fr",
    "identify campaign --set-aside 170=bumped --person Ada",
]


def type_all(folder):
    """Return the transcript of all commands, typed in a folder with copies of the examples."""
    shutil.copytree(_EXAMPLES / "campaign", folder / "campaign")
    shutil.copytree(_EXAMPLES / "campaign", folder / "archive" / "first")
    shutil.copy(_EXAMPLES / "wave" / "held-out.csv", folder)
    (folder / "targets.csv").write_text(_TARGETS)
    taken = Transcript("commands")
    for command in COMMANDS:
        before = set(folder.rglob("*"))
        done = typed(*command.split(), cwd=folder)
        taken.add(
            f"$ truepose {command}", f"-> {done.returncode}", *_told(done.stdout), *_marked(done.stderr)
        )
        written = sorted(path for path in set(folder.rglob("*")) - before if path.is_file())
        taken.add(*(f"wrote {path.relative_to(folder)}: {_first_line(path)}" for path in written), "")
    return taken


def _told(text):
    try:
        return [printed(json.loads(text))]
    except ValueError:
        return text.splitlines()


def _marked(text):
    return [f"! {line}" for line in text.splitlines()]


def _first_line(path):
    line = path.read_bytes()[:120].partition(b"\n")[0].decode("utf-8", "replace")
    return line if line.isprintable() else "no text"
