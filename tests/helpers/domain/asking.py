"""What persons ask of a session under way; each returns the sentence of the answer."""

from truepose.sequencing.engine.acts import Act, ActName


async def confirm(runner, person, accepted_serial="", prompt_id=None):
    act = Act(ActName.CONFIRM, person, accepted_serial=accepted_serial, prompt_id=prompt_id)
    return (await runner.ask(act)).sentence


async def resume(runner, person, prompt_id=None):
    return (await runner.ask(Act(ActName.RESUME, person, prompt_id=prompt_id))).sentence


async def pause(runner, person=""):
    return (await runner.ask(Act(ActName.PAUSE, person))).sentence


async def end(runner, person=""):
    return (await runner.ask(Act(ActName.ABORT, person))).sentence
