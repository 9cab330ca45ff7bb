"""An ACME G1 that the contract suite asks."""

from acme_gauge import PLUGIN, AcmeGauge

from truepose_drivers.contract.bench import BallbarBench


class AcmeGaugeBench(BallbarBench):
    """Knows what it shows."""

    plugin = PLUGIN
    specials = {"inches": "unit", "frozen": "frozen"}
    absent = {
        "answers_to_others_are_no_reading": "it has no keys, and serves one program at a time",
        "impossible_values_are_no_reading": "whatever five digits say, it may show",
    }
    count = 0

    def driver(self, wiring):
        """Return the driver on a line to this gauge."""
        return AcmeGauge(wiring.line(self.answer), wiring.clock)

    def answer(self, data):
        """Return what it says to a question."""
        if data == b"WHO\n":
            return [f"ACME G1 {self.serial} 1.0\n".encode()]
        self.count += self.fault != "frozen"
        value, unit = (self.true_mm / 25.4, "in") if self.fault == "inches" else (self.true_mm, "mm")
        return [f"SHOWS {self.count:06d} {unit} {value:+.4f} OK\n".encode()]
