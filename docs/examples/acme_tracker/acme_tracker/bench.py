"""An ACME tracker that the contract suite asks."""

from acme_tracker.driver import PLUGIN, AcmeTracker
from truepose_drivers.contract.bench import TrackerBench


class AcmeTrackerBench(TrackerBench):
    """Knows where its reflector is, and in which unit it speaks."""

    plugin = PLUGIN
    free_numbers = True  # "412.5000" and "12.5000" are both points
    specials = {"inches": "unit", "repeats": "frozen", "nowhere": "nonsense"}
    absent = {"answers_to_others_are_no_reading": "it serves one program at a time"}

    def __init__(self):
        super().__init__()
        self.number = 0
        self.unit = "in"  # as it is switched on

    def driver(self, wiring):
        """Return the driver on a line to this tracker."""
        return AcmeTracker(wiring.line(self.answer), wiring.clock)

    def answer(self, data):
        """Return what it says to a question."""
        match data.split()[0]:
            case b"WHO":
                return [f"ACME T1 {self.serial} 1.0\n".encode()]
            case b"MODE_MM":
                self.unit = "mm"
                return [b"OK\n"]
        self.number += self.fault != "repeats"
        return [f"POINT {self.number} {self.unit} 1 {self._place()} 0.0100 0.0100 0.0100 0.0200\n".encode()]

    def _place(self):
        if self.fault == "nowhere":
            return "nan inf 0.0000"
        per_mm = 25.4 if self.unit == "in" else 1.0
        return " ".join(f"{value / per_mm:.4f}" for value in self.point_mm)

    def special(self, name, wiring, rng):
        """Switch to inches as somebody does at the tracker, or fail as `answer` says."""
        super().special(name, wiring, rng)
        if name == "inches":
            self.unit = "in"
