"""Accepts the REST interface as it is (docs/interface.json): at a release, or where a break is meant."""

from pathlib import Path

from tests.helpers.web.interface import interface_of, written
from truepose.app import create_app
from truepose.settings import Settings


def main():
    """Write it."""
    document = create_app(Settings()).openapi()
    Path("docs/interface.json").write_text(written(interface_of(document)), encoding="utf-8")


if __name__ == "__main__":
    main()
