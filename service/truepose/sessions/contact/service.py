"""Sessions of closed loops behind the desk: how they are planned, what runs them, what they amount to."""

import asyncio
from collections.abc import Sequence

from truepose.analysis.campaigns.contacts import contact_campaign, judged_by_contacts, readings_of
from truepose.domain.campaign import Campaign
from truepose.domain.cell import Cell
from truepose.domain.contacts import ContactPlan, ContactTaken
from truepose.domain.errors import ConfigurationError
from truepose.messages.message import Text, message
from truepose.planning.contacts.plan import plan_of
from truepose.planning.contacts.plan_request import ContactPlanRequest
from truepose.planning.errors import PlanningError
from truepose.planning.workspace.bodies import bodies_of
from truepose.sessions.contact.dry_run import check_plan, ways_to
from truepose.sessions.contact.measuring import ContactCell, GaugeBox
from truepose.sessions.contact.runner import ContactRunner
from truepose.sessions.engine.interlocks import motion_limits
from truepose.sessions.engine.robot import WatchfulRobot
from truepose.sessions.engine.ways import judged_ways, look_in
from truepose.sessions.errors import MissingDeviceError, PlanRefusedError
from truepose.sessions.kind_service import UnattendedSessionService
from truepose.storage.ledger.entries import SessionLedger
from truepose.storage.records import RequestKey, SessionRecord, SessionSetup
from truepose_drivers.api import MotionLimits


class ContactSessions(UnattendedSessionService[ContactRunner]):
    """Sessions in which gauges are read against targets that stand still."""

    roles = frozenset({"contacts"})
    called = "session of closed loops"
    no_tracker = "session.refused.no_tracker"

    async def plan(
        self, name: str, setup: SessionSetup, wanted: ContactPlanRequest, key: RequestKey | None = None
    ) -> int:
        """Store a planned session and return its number; nothing moves.

        Raises PlanRefusedError, KeyReusedError, and what the choice of stops raises.
        """
        made = None if key is None else await self.desk.sessions.answered(key)
        if made is not None:
            return made
        plan = await asyncio.to_thread(_chosen, setup.cell, wanted)
        notice = await self.what_to_watch(setup, plan)
        return await self.desk.sessions.add(name, setup, plan, key, notice)

    async def what_to_watch(self, setup: SessionSetup, plan: ContactPlan) -> Text:
        """Return what to watch on the ways of a plan; raises PlanRefusedError where the cell cannot do it."""
        return await asyncio.to_thread(_judged, setup.cell, plan)

    async def campaign(self, session_id: int, judging_id: int | None = None) -> Campaign:
        """Return the campaign of what was read; with another session, held out, that judges its model.

        Raises NotFoundError, NothingMeasuredError, SessionsDifferError.
        """
        name, plan, taken = await self._measured(session_id)
        setup = await self.desk.sessions.setup(session_id)
        gauges = {mounted.entry.name for mounted, _ in self.desk.rack.gauges}
        campaign = contact_campaign(name, setup, plan, taken, gauges)
        if judging_id is None:
            return campaign
        other, judging, held_out = await self._measured(judging_id)
        return judged_by_contacts(campaign, (plan, judging), other, held_out)

    async def _measured(self, session_id: int) -> tuple[str, ContactPlan, Sequence[ContactTaken]]:
        await self.get(session_id)
        lines = await self.desk.ledger.whole(session_id)
        plan = await self.desk.sessions.contact_plan(session_id)
        return f"session {session_id}", plan, readings_of(line.entry for line in lines)

    # what the desk asks for

    async def stored_plan(self, session_id: int) -> ContactPlan:
        """Return what a session does; raises NotFoundError."""
        return await self.desk.sessions.contact_plan(session_id)

    async def runner(
        self, record: SessionRecord, setup: SessionSetup, ledger: SessionLedger
    ) -> ContactRunner:
        """Return what runs a session, from the lines of its ledger; nothing moves yet."""
        plan = await self.desk.sessions.contact_plan(record.id)
        cell = self._cell(setup, await self.desk.speed_limits(setup))
        return await asyncio.to_thread(ContactRunner, plan, cell, ledger, ledger.earlier)

    def _cell(self, setup: SessionSetup, speed: MotionLimits) -> ContactCell:
        rack, cell = self.desk.rack, self.desk.present.bound(setup.cell)
        boxes = tuple(
            GaugeBox(mounted.entry.name, gauge, mounted.expected_serial) for mounted, gauge in rack.gauges
        )
        if not boxes:
            raise MissingDeviceError(message("session.refused.no_gauge"))
        return ContactCell(
            gauges=boxes,
            robot_controller=WatchfulRobot(rack.robot, cell.robot.joint_limits),
            clock=rack.clock,
            robot=cell.robot,
            look_at_ways=look_in(bodies_of(cell)),
            base=cell.base_nominal,
            joint_limits=cell.limits.joints,
            speed_limits=speed,
            attachment=setup.attachment,
            robot_serial=rack.expected().serials.get("robot", ""),
        )


def _judged(cell: Cell, plan: ContactPlan) -> Text:
    check_plan(plan, cell.robot, cell.base_nominal, motion_limits(cell.robot, cell.limits.joints))
    return judged_ways(bodies_of(cell), ways_to(plan.stops))


def _chosen(cell: Cell, wanted: ContactPlanRequest) -> ContactPlan:
    try:
        return plan_of(cell, wanted)
    except (PlanningError, ConfigurationError) as error:
        raise PlanRefusedError(error.text) from error
