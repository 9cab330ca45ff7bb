"""Small campaigns in a folder, and workers that are this process."""

from collections import deque

from truepose.analysis.archive import Archive, in_folder
from truepose.analysis.parallel.tasks import Cluster
from truepose_simulators.recording.campaign import record
from truepose_simulators.recording.files import write_campaign
from truepose_simulators.recording.plan import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario


class ThisProcess:
    """Computes a task when it is waited for; `most` tasks, then the computer goes off."""

    def __init__(self, most=1000):
        self._waiting = deque()
        self._most = most
        self.performed = 0

    def room(self):
        return 1 - len(self._waiting)

    def begin(self, task):
        self._waiting.append(task)

    def ended(self):
        if self.performed == self._most:
            raise KeyboardInterrupt
        self.performed += 1
        task = self._waiting.popleft()
        return task.number, task.perform()

    def give_up(self):
        self._waiting.clear()


def written_archive(folder, readings):
    """Write campaigns with so many readings, each in a folder of its own: campaign-1, campaign-2."""
    scenario = load_scenario("irb120-clean")
    for number, size in enumerate(readings, start=1):
        write_campaign(record(scenario, number, RecordingRequest(size, 0)), folder / f"campaign-{number}")
    return folder


def computed(folder, out, places=None, **options):
    """Compute an archive in this process; return what came of it and how many tasks that took."""
    places = places or ThisProcess()
    anew = Archive(in_folder(folder), out, **options).compute(Cluster(places), lambda *_: None)
    return anew, places.performed
