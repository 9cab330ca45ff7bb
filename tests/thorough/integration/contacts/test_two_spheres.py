"""How exact a closed loop at two spheres makes an arm."""

from tests.integration.contacts.test_closed_loops import LR_MATE, run, wish
from truepose.analysis.campaigns.contacts import contact_campaign, judged_by_contacts, readings_of
from truepose.domain.contacts import TargetDistance
from truepose.identification.identify import identify
from truepose.planning.contacts.plan import plan_of
from truepose.storage.records import SessionSetup


async def test_two_spheres_make_the_arm_better_where_nothing_of_it_was_read():
    distance = TargetDistance((1, 2), 240.0, 0.003)
    plan, judging = (
        plan_of(LR_MATE, wish("lrmate-two-spheres", stops=stops, distances=(distance,), seed=seed))
        for stops, seed in ((40, 1), (8, 2))
    )
    _, read = await run("lrmate-two-spheres", plan)
    _, held_out = await run("lrmate-two-spheres", judging)

    campaign = contact_campaign("session 1", SessionSetup(LR_MATE), plan, readings_of(read.entries))
    judged = judged_by_contacts(campaign, (plan, judging), "session 2", readings_of(held_out.entries))
    found = identify(judged).validation

    assert found.nominal.mean_mm > 0.08
    # Scatter of the arm is 3.5 um, of a reading 0.5 um; the rest is what 50 distances leave open elsewhere.
    assert found.identified.mean_mm < 0.01
