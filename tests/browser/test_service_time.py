"""What time a page thinks it is at the service, whatever its network does with the answers."""

import pytest

HEARD = """async (answers) => {
  const { hear, now_s } = await import("/static/service-time.js");
  const clock = performance.now;
  const times = [];
  for (const [at_s, told_s] of answers) {
    performance.now = () => 1000 * at_s;
    hear(new Response("", { headers: { "Truepose-Time": String(told_s) } }));
    times.push(now_s());
  }
  performance.now = clock;
  return times;
}"""


# What is answered, [s] at the page and at the service, and what time it is then.
CASES = {
    "quick answers are believed": ([(10, 100), (11, 101)], [100, 101]),
    "an answer that was late changes nothing": ([(10, 100), (20, 105)], [100, 110]),
    "a quicker one mends a late one": ([(10, 95), (11, 101)], [95, 101]),
    "a host that was started anew has another clock": ([(10, 5000), (40, 20)], [5000, 20]),
    "a tablet's clock that runs fast is followed": ([(0, 100), (600, 699.5)], [100, 699.5]),
}


def test_it_is_the_time_of_the_quickest_answer_and_never_later(service, tablet):
    heard = {}
    for case, (answers, _) in CASES.items():
        tablet.goto(f"{service.url}/errors")  # where nothing was heard before
        heard[case] = tablet.evaluate(HEARD, [list(answer) for answer in answers])

    assert heard == {case: pytest.approx(times, abs=0.02) for case, (_, times) in CASES.items()}
