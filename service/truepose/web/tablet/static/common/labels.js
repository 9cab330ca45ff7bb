// Where names stand in the picture: near their point, on no other name, ball or bar, inside the frame. Pure.

const DIRECTIONS = 16;
const DISTANCES = [1, 1.5, 2.1, 2.9, 3.8];
const GAP_PX = 4;

const overlap = (a, b) =>
  Math.max(0, Math.min(a.right, b.right) - Math.max(a.left, b.left) + GAP_PX) *
  Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) + GAP_PX);

function box(x, y, label) {
  const [across, down] = [label.width / 2, label.height / 2];
  return { left: x - across, right: x + across, top: y - down, bottom: y + down };
}

function around(point, radius) {
  return { left: point.x - radius, right: point.x + radius, top: point.y - radius, bottom: point.y + radius };
}

// A thick line is covered by boxes; good enough to keep a name off it.
function along(line, thickness) {
  const [a, b] = line;
  const n = Math.max(2, Math.ceil(Math.hypot(b.x - a.x, b.y - a.y) / thickness));
  return Array.from({ length: n + 1 }, (_, i) => {
    const share = i / n;
    return around({ x: a.x + share * (b.x - a.x), y: a.y + share * (b.y - a.y) }, thickness / 2);
  });
}

function outside(found, size) {
  return (
    Math.max(0, -found.left) + Math.max(0, -found.top) +
    Math.max(0, found.right - size.width) + Math.max(0, found.bottom - size.height)
  );
}

function candidates(label) {
  const near = label.radius + GAP_PX;
  return DISTANCES.flatMap((distance) =>
    Array.from({ length: DIRECTIONS }, (_, i) => {
      const angle = -Math.PI / 2 + (2 * Math.PI * i) / DIRECTIONS;
      const reach_x = (near + label.width / 2) * distance;
      const reach_y = (near + label.height / 2) * distance;
      const x = label.x + reach_x * Math.cos(angle);
      const y = label.y + reach_y * Math.sin(angle);
      return { x, y, far: distance, box: box(x, y, label) };
    }),
  );
}

// `labels`: { x, y, radius, width, height } in order of importance; `lines`: pairs of points to keep clear.
// Returns the centres of the names, in the same order.
export function placed(labels, lines, size) {
  const balls = labels.map((label) => around(label, label.radius));
  const bars = lines.flatMap(({ line, thickness }) => along(line, thickness));
  const taken = [];
  return labels.map((label) => {
    const cost = (candidate) => {
      const on = (boxes) => boxes.reduce((sum, other) => sum + overlap(candidate.box, other), 0);
      return 1e3 * outside(candidate.box, size) + 50 * on(taken) + 8 * on(balls) + 4 * on(bars) + 60 * candidate.far;
    };
    const best = candidates(label).reduce((a, b) => (cost(b) < cost(a) ? b : a));
    taken.push(best.box);
    return { x: best.x, y: best.y, far: best.far };
  });
}
