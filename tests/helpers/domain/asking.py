"""What persons ask of a session under way; each returns the sentence of the answer."""

from truepose.sessions.engine.commands import CommandName, OperatorCommand


def question(runner):
    """What is asked now; empty where nothing is."""
    return "" if runner.prompt is None else runner.prompt.message


async def confirm(runner, person, accepted_serial="", prompt_id=None):
    act = OperatorCommand(CommandName.CONFIRM, person, accepted_serial=accepted_serial, prompt_id=prompt_id)
    return (await runner.ask(act)).sentence


async def resume(runner, person, prompt_id=None):
    return (await runner.ask(OperatorCommand(CommandName.RESUME, person, prompt_id=prompt_id))).sentence


async def pause(runner, person=""):
    return (await runner.ask(OperatorCommand(CommandName.PAUSE, person))).sentence


async def end(runner, person=""):
    return (await runner.ask(OperatorCommand(CommandName.ABORT, person))).sentence
