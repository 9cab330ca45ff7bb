// Bodies of the space picture, made of numbers in mm in the world; the z axis points up.

import {
  BufferAttribute, BufferGeometry, CapsuleGeometry, Color, ConeGeometry, GridHelper, Group, InstancedMesh, LineBasicMaterial,
  LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshStandardMaterial, Points, PointsMaterial, Quaternion,
  SphereGeometry, Vector3,
} from "/static/packages/three.js";

const UP = new Vector3(0, 1, 0); // along which three.js makes capsules and cones
const GRID_MM = 100;
const HEAD = { share: 0.3, least_mm: 1.5, most_mm: 22, slim: 0.32 }; // of an arrow

function along(vector) {
  return new Quaternion().setFromUnitVectors(UP, vector.clone().normalize());
}

function capsule([x1, y1, z1, x2, y2, z2, radius], material) {
  const [from, to] = [new Vector3(x1, y1, z1), new Vector3(x2, y2, z2)];
  const way = to.clone().sub(from);
  const body = new Mesh(new CapsuleGeometry(radius, way.length(), 6, 16), material);
  body.position.copy(from).addScaledVector(way, 0.5);
  if (way.length() > 0) body.quaternion.copy(along(way));
  return body;
}

export function arm(pieces_mm, colour) {
  const group = new Group();
  const painted = new Color(colour).lerp(new Color(0xffffff), 0.4); // lighter than text of that colour
  const material = new MeshStandardMaterial({ color: painted, roughness: 0.75, metalness: 0.1 });
  group.add(...pieces_mm.map((piece) => capsule(piece, material)));
  return group;
}

export function places(points_mm, colour, size = 3) {
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(points_mm.flat()), 3));
  return new Points(geometry, new PointsMaterial({ color: colour, size, sizeAttenuation: false }));
}

export function ball(centre_mm, radius_mm, colour) {
  const body = new Mesh(new SphereGeometry(radius_mm, 24, 16), new MeshStandardMaterial({ color: colour }));
  body.position.set(...centre_mm);
  return body;
}

// Vectors from points, `times` longer than they are: a line and a head each.
export function arrows(points_mm, vectors_mm, times, colour) {
  const ends = points_mm.map((point, i) => point.map((value, axis) => value + times * vectors_mm[i][axis]));
  const lines = new BufferGeometry();
  const corners = points_mm.flatMap((point, i) => [...point, ...ends[i]]);
  lines.setAttribute("position", new BufferAttribute(new Float32Array(corners), 3));
  const group = new Group();
  group.add(new LineSegments(lines, new LineBasicMaterial({ color: colour })), heads(vectors_mm, ends, times, colour));
  return group;
}

function heads(vectors_mm, ends, times, colour) {
  const cones = new InstancedMesh(new ConeGeometry(1, 1, 8).translate(0, -0.5, 0), new MeshBasicMaterial({ color: colour }), ends.length);
  ends.forEach((end, i) => {
    const vector = new Vector3(...vectors_mm[i]);
    const length = Math.min(HEAD.most_mm, Math.max(HEAD.least_mm, HEAD.share * times * vector.length()));
    const size = new Vector3(HEAD.slim * length, length, HEAD.slim * length);
    cones.setMatrixAt(i, new Matrix4().compose(new Vector3(...end), along(vector), size));
  });
  return cones;
}

export function ground(reach_mm, colour) {
  const cells = 2 * Math.ceil(reach_mm / GRID_MM);
  const grid = new GridHelper(cells * GRID_MM, cells, colour, colour);
  grid.rotation.x = Math.PI / 2;
  return grid;
}
