"""The compose file, read and resolved without an engine."""

import shlex

import jsonschema
import pytest

from tests.integration.deployment.compose_schema import COMPOSE_SCHEMA
from tests.integration.deployment.deployment_files import (
    CHECKOUT,
    compose_file,
    dockerfiles,
    sent_to_the_engine,
)
from truepose.exchange.cells.file import read_cell

_SERVICES = compose_file()["services"]


def _volumes():
    return [volume for service in _SERVICES.values() for volume in service.get("volumes", [])]


def test_the_compose_file_fits_its_schema():
    jsonschema.Draft202012Validator.check_schema(COMPOSE_SCHEMA)

    faults = jsonschema.Draft202012Validator(COMPOSE_SCHEMA).iter_errors(compose_file())

    assert [fault.message for fault in faults] == []


@pytest.mark.parametrize(
    "spoil",
    [
        lambda file: file["services"]["cell"].update(port=["7000:7000"]),
        lambda file: file["services"]["cell"].update(ports="7000:7000"),
        lambda file: file["services"]["service"]["healthcheck"].update(interval="ten seconds"),
        lambda file: file["services"]["service"]["depends_on"]["cell"].update(condition="healthy"),
        lambda file: file.update(service={}),
    ],
    ids=["unknown key", "not a list", "no duration", "unknown condition", "unknown element"],
)
def test_the_schema_refuses_what_an_engine_would(spoil):
    file = compose_file()

    spoil(file)

    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(file, COMPOSE_SCHEMA)


def test_every_network_and_service_that_is_named_is_declared():
    file = compose_file()

    used = {network for service in _SERVICES.values() for network in service.get("networks", [])}
    waited_for = {name for service in _SERVICES.values() for name in service.get("depends_on", {})}

    assert used == set(file["networks"])
    assert waited_for <= set(_SERVICES)
    assert all("healthcheck" in _SERVICES[name] for name in waited_for)


def test_the_instruments_are_on_a_private_network_and_nowhere_else():
    networks = compose_file()["networks"]

    assert _SERVICES["cell"]["networks"] == ["cell"]
    assert networks["cell"]["internal"] is True
    assert "ports" not in _SERVICES["cell"]


def test_the_service_is_published_to_this_computer_alone():
    addresses = [port.rsplit(":", 2) for port in _SERVICES["service"]["ports"]]

    assert [address for address, _, _ in addresses] == ["127.0.0.1"]


def test_every_volume_is_a_file_of_the_checkout_or_declared():
    declared = set(compose_file()["volumes"])

    sources = {
        volume.split(":")[0] for service in _SERVICES.values() for volume in service.get("volumes", [])
    }

    files = {source for source in sources if source.startswith(".")}
    assert all((CHECKOUT / file).is_file() for file in files)
    assert sources - files == declared


def test_the_database_lies_on_the_volume():
    command = _SERVICES["service"]["command"]
    url = command[command.index("--database") + 1]

    folders = [
        volume.split(":")[1] for volume in _SERVICES["service"]["volumes"] if volume.startswith("data:")
    ]

    assert [url.startswith(f"sqlite:///{folder}/") for folder in folders] == [True]


def test_the_cell_file_is_mounted_where_the_command_looks_for_it():
    command = _SERVICES["service"]["command"]
    wanted = command[command.index("--cell") + 1]

    mounted = {volume.split(":")[1]: volume.split(":")[0] for volume in _volumes()}

    assert read_cell(CHECKOUT / mounted[wanted]).devices


def test_the_cell_files_hosts_are_services_of_the_same_network():
    cell = read_cell(CHECKOUT / "docs" / "examples" / "networked-cell.toml")

    hosts = {device.options["host"] for device in cell.devices}

    shared = set(_SERVICES["service"]["networks"])
    assert hosts == {"cell"}
    assert all(shared & set(_SERVICES[host]["networks"]) for host in hosts)


@pytest.mark.parametrize("name", list(_SERVICES))
def test_every_file_that_an_image_copies_exists_and_reaches_the_engine(name):
    sources = [source for sources, _ in dockerfiles()[name].copies() for source in sources]

    assert sources
    assert [source for source in sources if not (CHECKOUT / source).exists()] == []
    assert [source for source in sources if not sent_to_the_engine(source)] == []


def test_nothing_else_reaches_the_engine():
    copied = {
        source.split("/")[0]
        for file in dockerfiles().values()
        for sources, _ in file.copies()
        for source in sources
    }

    sent = {entry.name for entry in CHECKOUT.iterdir() if sent_to_the_engine(entry.name)}

    assert sent == copied


@pytest.mark.parametrize("name", list(_SERVICES))
def test_no_image_runs_as_root(name):
    instructions = [instruction for instruction, _ in dockerfiles()[name].instructions]

    assert "USER" in instructions
    assert instructions.index("USER") < instructions.index("CMD")


def test_what_the_simulators_image_installs_is_a_dependency_of_the_project():
    project = (CHECKOUT / "pyproject.toml").read_text(encoding="utf-8")

    (install,) = [run for run in dockerfiles()["cell"].all("RUN") if "pip install" in run]

    (requirement,) = [word for word in shlex.split(install) if ">=" in word]
    assert f'"{requirement}"' in project
