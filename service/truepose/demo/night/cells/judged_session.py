"""A calibration without a tracker, judged by the tracker of its cell: the model knows no world frame."""

from typing import Final

from truepose.demo.cell.client import ServiceClient
from truepose.demo.night.check import Check, at_most, converged
from truepose.demo.progress import RunProgress

VALIDATION: Final = 60  # configurations of the tracker


async def judged_by_tracker(
    client: ServiceClient, session_id: int, seed: int, limit_mm: float, progress: RunProgress
) -> list[Check]:
    """Identify by a session, and judge after the best alignment; `limit_mm` is of the mean error."""
    with progress.phase("measuring validation configurations") as told:
        validation_id = await client.finish_job(
            await client.plan("validation", "validation", VALIDATION, seed), told
        )
        await client.run_session(validation_id, told)
    campaign = await client.campaign_of("night", [session_id, validation_id])
    with progress.phase("identifying") as told:
        number = await client.finish_job(await client.identify(campaign), told)
        identified = await client.get(f"/identifications/{number}")
    checks = [converged(identified["document"])]
    if identified["model_id"] is None:
        return checks
    with progress.phase("validating") as told:
        job = await client.validate(identified["model_id"], campaign, None)
        number = await client.finish_job(job, told)
    document = (await client.get(f"/validations/{number}"))["document"]
    aligned, distance = (document[key]["identified"]["mean_mm"] for key in ("relative", "distance"))
    return [
        *checks,
        at_most("measured error, aligned, mean", aligned, limit_mm, "mm"),
        at_most("error of distances, mean", distance, limit_mm, "mm"),
    ]
