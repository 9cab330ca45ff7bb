"""What the deployment's files say: the compose file and, of a Dockerfile, the instructions we use."""

import json
import re
import shlex
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

import yaml

CHECKOUT = Path(__file__).parents[3]


def compose_file():
    return yaml.safe_load((CHECKOUT / "docker-compose.yml").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Dockerfile:
    """Instructions with their arguments, continued lines joined, in order."""

    path: Path
    instructions: tuple[tuple[str, str], ...]

    def all(self, name):
        return [arguments for instruction, arguments in self.instructions if instruction == name]

    def copies(self):
        """Sources of every COPY with its destination."""
        words = [shlex.split(arguments) for arguments in self.all("COPY")]
        return [(parts[:-1], parts[-1]) for parts in words]

    def command(self):
        """The CMD in its exec form."""
        (command,) = self.all("CMD")
        return json.loads(command)


def read_dockerfile(path):
    text = re.sub(r"^\s*#.*\n", "", (CHECKOUT / path).read_text(encoding="utf-8"), flags=re.MULTILINE)
    lines = re.sub(r"\\\n", " ", text).splitlines()
    instructions = [line.split(maxsplit=1) for line in lines if line.strip()]
    return Dockerfile(CHECKOUT / path, tuple((name, arguments) for name, arguments in instructions))


def dockerfiles():
    services = compose_file()["services"]
    return {name: read_dockerfile(service["build"]["dockerfile"]) for name, service in services.items()}


def sent_to_the_engine(path):
    """Whether .dockerignore lets a path of the checkout into the build; the last rule that fits decides."""
    sent = True
    for line in (CHECKOUT / ".dockerignore").read_text(encoding="utf-8").splitlines():
        rule = line.strip()
        if rule and not rule.startswith("#"):
            pattern = rule.removeprefix("!")
            if fnmatch(path, pattern) or path.startswith(f"{pattern}/"):
                sent = rule.startswith("!")
    return sent
