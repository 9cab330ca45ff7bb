"""How young what a page shows is, measured against how long the machine takes for anything at all."""

# The age of each length when it is drawn, and the time of a round trip to the service, both at once.
_MEASURED = """async (duration_ms) => {
    const ages = [], trips = [];
    const gauge = document.querySelector("#gauge");
    const age = () => ages.push(Date.now() - Number(gauge.dataset.sampledAtMs));
    const watch = new MutationObserver(() => requestAnimationFrame(age));
    watch.observe(gauge, { attributes: true, attributeFilter: ["data-sampled-at-ms"] });
    for (const end = performance.now() + duration_ms; performance.now() < end;) {
        const began = performance.now();
        await fetch(location.href).then((reply) => reply.text());
        await new Promise(requestAnimationFrame);
        trips.push(performance.now() - began);
        await new Promise((resolve) => setTimeout(resolve, 50));
    }
    watch.disconnect();
    return [ages, trips];
}"""
_YOUNG_MS = 150  # from the instrument's sample to the screen, where nothing else keeps the machine


def drawn_ages(page, duration_ms):
    """Return the ages [ms] of the lengths as they are drawn, and how old they may be on this machine now."""
    ages, trips = (sorted(found) for found in page.evaluate(_MEASURED, duration_ms))
    return ages, _YOUNG_MS + 2 * trips[int(0.95 * len(trips))]
