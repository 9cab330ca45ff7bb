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


@pytest.mark.parametrize(
    ("answers", "times"),
    [
        pytest.param([(10, 100), (11, 101)], [100, 101], id="quick answers are believed"),
        pytest.param([(10, 100), (20, 105)], [100, 110], id="an answer that was late changes nothing"),
        pytest.param([(10, 95), (11, 101)], [95, 101], id="a quicker one mends a late one"),
        pytest.param([(10, 5000), (40, 20)], [5000, 20], id="a host that was started anew has another clock"),
        pytest.param(
            [(0, 100), (600, 699.5)], [100, 699.5], id="a tablet's clock that runs fast is followed"
        ),
    ],
)
def test_it_is_the_time_of_the_quickest_answer_and_never_later(service, tablet, answers, times):
    tablet.goto(f"{service.url}/errors")

    assert tablet.evaluate(HEARD, [list(answer) for answer in answers]) == pytest.approx(times, abs=0.02)
