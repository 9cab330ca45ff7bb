"""Commands that print what others need to run and watch the service."""

from importlib.resources import files

from truepose.cli.output import print_lines


def unit_command() -> int:
    """Print the systemd unit of the service.

    Example: truepose unit | sudo tee /etc/systemd/system/truepose.service
    """
    return _print("truepose.service")


def dashboard_command() -> int:
    """Print the Grafana dashboard of the figures at /metrics, to be imported there.

    Example: truepose dashboard > truepose.json
    """
    return _print("dashboard.json")


def _print(name: str) -> int:
    text = files("truepose").joinpath("app", "deployment", name).read_text(encoding="utf-8")
    print_lines(text.splitlines())
    return 0
