"""The repository's own pages as a site: README files and tables of figures too, with links as they stand."""

import csv
import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

import truepose

_REPOSITORY = Path(__file__).parents[2]
_BESIDE = (
    "CHANGELOG.md",
    *(f"{package}/**/README.md" for package in ("service", "drivers", "simulators", "tests")),
)
_LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^)\s#]+)(#[^)\s]*)?\)")
_FENCE, _ITEM = re.compile(r"\s*```"), re.compile(r"(-|\d+\.) ")
_NAMES = "names.md"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what lies beside docs/, tables of figures, and the names that `import truepose` offers."""
    for pattern in _BESIDE:
        for path in sorted(_REPOSITORY.glob(pattern)):
            name = path.relative_to(_REPOSITORY).as_posix()
            files.append(File.generated(config, name, content=path.read_text(encoding="utf-8")))
    for path in sorted((_REPOSITORY / "docs" / "figures").glob("*.csv")):
        files.append(File.generated(config, f"figures/{path.stem}.md", content=_figures(path)))
    start = (_REPOSITORY / "README.md").read_text(encoding="utf-8")
    files.append(File.generated(config, "index.md", content=start))
    files.append(File.generated(config, _NAMES, content=_names()))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links between files of the repository into links between pages; other files keep their names."""
    folder = posixpath.dirname(_in_repository(page.file.src_uri))

    def turned(link: re.Match[str]) -> str:
        image, text, target, anchor = link.groups(default="")
        if re.match(r"[a-z]+:", target):
            return link[0]
        place = _on_site(posixpath.normpath(posixpath.join(folder, target)))
        if files.get_file_from_path(place) is None:
            return text
        here = posixpath.dirname(page.file.src_uri)
        return f"{image}[{text}]({posixpath.relpath(place, here or '.')}{anchor})"

    return _LINK.sub(turned, _with_lists_apart(markdown))


def _with_lists_apart(markdown: str) -> str:
    """Put an empty line before a list that follows a line of text: Python-Markdown takes it for text else."""
    lines: list[str] = []
    coded, listed = False, False
    for line in markdown.splitlines():
        coded ^= _FENCE.match(line) is not None
        begins = _ITEM.match(line) is not None and not coded
        if begins and not listed and lines and lines[-1].strip():
            lines.append("")
        listed = bool(line.strip()) and (begins or (listed and not coded))
        lines.append(line)
    return "\n".join(lines)


def _in_repository(page: str) -> str:
    """Return where the source of a page lies in the repository."""
    if page == "index.md":
        return "README.md"
    return page if (_REPOSITORY / page).is_file() else f"docs/{page}"


def _on_site(path: str) -> str:
    if path == "README.md":
        return "index.md"
    return re.sub(r"^(figures/\w+)\.csv$", r"\1.md", path.removeprefix("docs/"))


def _figures(path: Path) -> str:
    """Return a table of figures as a page."""
    with path.open(newline="", encoding="utf-8") as file:
        heads, *rows = csv.reader(file)
    lines = (f"| {' | '.join(row)} |" for row in (heads, ["---"] * len(heads), *rows))
    return "\n".join([f"# {path.stem.capitalize()}", "", *lines, ""])


def _names() -> str:
    entries = (f"::: truepose.{name}" for name in truepose.__all__ if name != "__version__")
    return "\n\n".join(["# Names of `import truepose`", *entries, ""])
