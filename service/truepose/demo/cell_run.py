"""One simulated cell from start to judgement: measured, modelled, diagnosed, and compared with its truth.

Everything that a user of a real cell does goes through the service's REST interface, and through its
drivers to the instruments; the truth endpoint, which no real cell has, is asked directly.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from truepose.demo.client import ServiceClient, open_client
from truepose.demo.errors import TruthUnknownError
from truepose.demo.processes import DATABASE, SERVICE_LOG, SimulatedService, running_service
from truepose.demo.progress import RunProgress
from truepose.demo.truth import TrueReadings, camera_artefact, cell_endpoint, true_poses
from truepose.domain.campaign import Campaign
from truepose.domain.cell import Cell
from truepose.domain.identification import Model
from truepose.exchange.campaigns.folder import write_campaign
from truepose.exchange.campaigns.zip_file import read_campaign_zip
from truepose.exchange.cells.file import simulated_cell
from truepose.exchange.models.file import model_from_text

CAMPAIGN_FOLDER: Final = "campaign"
MODEL_FILE: Final = "model.json"


@dataclass(frozen=True, slots=True)
class CellRequest:
    """Which cell, and how much is measured on it."""

    scenario: str  # shipped name or file
    seed: int
    calibration: int = 50  # configurations, revisits not counted
    validation: int = 1000
    limit_mm: float | None = None  # largest error that passes the validation
    validate_after_s: float = 0.0  # cell time before which no validation reading is taken


@dataclass(frozen=True, slots=True)
class SessionRecords:
    """What the service recorded of cell, devices and sessions, as its REST interface gives it."""

    cell: dict[str, Any]
    devices: list[dict[str, Any]]
    plan: dict[str, Any]  # of the calibration; the validation has the same speeds and times
    calibration: dict[str, Any]
    validation: dict[str, Any]


@dataclass(frozen=True, slots=True)
class CellRun:
    """What a run gave: the service's documents, what they are about, and the truth."""

    request: CellRequest
    identification: dict[str, Any]
    validation: dict[str, Any] | None  # None: there is no model
    diagnosis: dict[str, Any]  # the service's record of it, with the document
    campaign: Campaign
    model: Model | None
    true: TrueReadings
    records: SessionRecords

    @property
    def converged(self) -> bool:
        """Whether the identification ended well."""
        return bool(self.identification["status"] == "converged")

    @property
    def passed(self) -> bool:
        """Whether a model was identified and held its limit."""
        return self.converged and self.validation is not None and bool(self.validation["pass"])


async def run_cell(request: CellRequest, out: Path, progress: RunProgress) -> CellRun:
    """Run a cell and leave database, log, campaign folder and model file in `out`.

    Raises
    ------
    DemoError
        Its subclass says what failed; what was measured until then is in the database.
    """
    service = SimulatedService(request.scenario, request.seed, out / DATABASE, out / SERVICE_LOG)
    progress.doing = "starting the service and its cell"
    async with running_service(service) as url, open_client(url) as client:
        await client.end_left_sessions()
        await client.connect_devices()
        endpoints = await _endpoints(client)
        sessions = await _measure(client, endpoints, request, progress)
        campaign_id = await client.make_campaign("demo", *sessions)
        diagnosing = await client.diagnose(campaign_id)  # beside what follows, by another worker
        identifying = await client.identify(campaign_id)
        campaign = read_campaign_zip(await client.download(f"/campaigns/{campaign_id}/archive"))
        write_campaign(campaign, out / CAMPAIGN_FOLDER)
        with progress.phase("identifying") as told:
            identified = await client.result_of(identifying, "identifications", told)
        validation = await _validate(client, identified["model_id"], campaign_id, request, progress)
        with progress.phase("diagnosing") as told:
            diagnosis = await client.result_of(diagnosing, "diagnoses", told)
        return CellRun(
            request=request,
            identification=identified["document"],
            validation=validation,
            diagnosis=diagnosis,
            campaign=campaign,
            model=await _model(client, identified["model_id"], out / MODEL_FILE),
            true=await _truth(endpoints["truth"], campaign, simulated_cell(request.scenario, request.seed)),
            records=await _records(client, *sessions),
        )


_Endpoints = Mapping[str, tuple[str, int]]


async def _endpoints(client: ServiceClient) -> _Endpoints:
    (cell,) = await client.get("/cells")
    return {entry["device"]: (entry["host"], entry["port"]) for entry in cell["endpoints"]}


async def _validate(
    client: ServiceClient,
    model_id: int | None,
    campaign_id: int,
    request: CellRequest,
    progress: RunProgress,
) -> dict[str, Any] | None:
    if model_id is None:
        return None
    with progress.phase("validating") as told:
        job = await client.validate(model_id, campaign_id, request.limit_mm)
        judged = await client.result_of(job, "validations", told)
    document: dict[str, Any] = judged["document"]
    return document


async def _records(client: ServiceClient, calibration_id: int, validation_id: int) -> SessionRecords:
    (cell,) = await client.get("/cells")
    return SessionRecords(
        cell=cell,
        devices=await client.get("/devices"),
        plan=await client.get(f"/sessions/{calibration_id}/plan"),
        calibration=await client.get(f"/sessions/{calibration_id}"),
        validation=await client.get(f"/sessions/{validation_id}"),
    )


async def _measure(
    client: ServiceClient, endpoints: _Endpoints, request: CellRequest, progress: RunProgress
) -> tuple[int, int]:
    """Run both sessions and return their numbers."""
    with progress.phase("choosing calibration configurations") as told:
        job = await client.plan("calibration", "calibration", request.calibration, request.seed)
        calibration_id = await client.finish_job(job, told)
    # A worker draws the validation configurations while the robot is busy with the calibration.
    drawing = await client.plan("validation", "validation", request.validation, request.seed)
    with progress.phase("measuring calibration configurations") as told:
        await client.run_session(calibration_id, told)
    with progress.phase("drawing validation configurations") as told:
        validation_id = await client.finish_job(drawing, told)
    await _wait_until(request.validate_after_s, endpoints["clock"])
    with progress.phase("measuring validation configurations") as told:
        await client.run_session(validation_id, told)
    return calibration_id, validation_id


async def _wait_until(time_s: float, address: tuple[str, int]) -> None:
    """Let cell time go by; at pace 0 that takes no wall time."""
    if time_s <= 0.0:
        return
    async with cell_endpoint(*address) as clock:
        now_s = (await clock.ask("now"))["now_s"]
        await clock.ask("sleep", s=max(time_s - now_s, 0.0))


async def _model(client: ServiceClient, model_id: int | None, file: Path) -> Model | None:
    if model_id is None:
        return None
    text = await client.download(f"/models/{model_id}/file")
    file.write_bytes(text)
    return model_from_text(text, file.name)


async def _truth(address: tuple[str, int], campaign: Campaign, cell: Cell) -> TrueReadings:
    if campaign.calibration is None or campaign.validation is None:
        raise TruthUnknownError("The campaign has no readings to compare with their true values.")
    async with cell_endpoint(*address) as endpoint:
        shown = camera_artefact(cell)
        if shown is not None:
            return await true_poses(endpoint, campaign.calibration, campaign.validation, shown)
        return TrueReadings(
            calibration_mm=await endpoint.positions_mm(campaign.calibration),
            validation_mm=await endpoint.positions_mm(campaign.validation),
            tool_nests_mm=await endpoint.tool_nests_mm(),
        )
