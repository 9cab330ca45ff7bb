// From the world [mm] to the picture [px]: a pinhole at the person's eyes, turned to what is to be done. Pure.

const MARGIN_PX = 46; // for the balls and for labels at the rim
const MARGIN_SHARE = 0.13; // of a picture that is small
const NEAREST = 2.2; // times the size of what is seen: closer, the perspective would exaggerate

const minus = (a, b) => a.map((value, i) => value - b[i]);
const along = (a, direction, distance) => a.map((value, i) => value + distance * direction[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((value) => value / (Math.hypot(...a) || 1));

function eye(scene, reach_mm) {
  const back = unit(minus(scene.stand_mm, scene.look_at_mm));
  const distance_mm = Math.hypot(...minus(scene.stand_mm, scene.look_at_mm));
  return along(scene.look_at_mm, back, Math.max(distance_mm, NEAREST * reach_mm));
}

function axes(forward) {
  const level = cross(forward, [0, 0, 1]);
  // Looking straight down there is no horizon: the world's x is right.
  const right = Math.hypot(...level) < 1e-6 ? [1, 0, 0] : unit(level);
  return { forward, right, up: cross(right, forward) };
}

function bounds(points) {
  const xs = points.map((point) => point.x);
  const ys = points.map((point) => point.y);
  return { left: Math.min(...xs), right: Math.max(...xs), top: Math.min(...ys), bottom: Math.max(...ys) };
}

// Returns a function from the world to the picture; `framed_mm` fill the picture of `width` x `height`.
// Each result has x, y [px], depth [mm], and `scale` [px per mm] at that depth.
export function camera(scene, framed_mm, width, height) {
  const reach_mm = Math.max(...framed_mm.map((point) => Math.hypot(...minus(point, scene.look_at_mm))), 1);
  const from = eye(scene, reach_mm);
  const { forward, right, up } = axes(unit(minus(scene.look_at_mm, from)));
  const seen = (point) => {
    const ray = minus(point, from);
    const depth = Math.max(dot(ray, forward), 1);
    return { x: dot(ray, right) / depth, y: -dot(ray, up) / depth, depth };
  };
  const frame = bounds(framed_mm.map(seen));
  const margin_px = Math.min(MARGIN_PX, MARGIN_SHARE * Math.min(width, height));
  const room = (span, size) => (size - 2 * margin_px) / Math.max(span, 1e-6);
  const zoom = Math.min(room(frame.right - frame.left, width), room(frame.bottom - frame.top, height));
  const place = (value, low, high, size) => size / 2 + zoom * (value - (low + high) / 2);
  return (point) => {
    const { x, y, depth } = seen(point);
    return {
      x: place(x, frame.left, frame.right, width),
      y: place(y, frame.top, frame.bottom, height),
      depth,
      scale: zoom / depth,
    };
  };
}
