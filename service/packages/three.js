// What the pages use of three.js; whatever is not named here is left out of the bundle.
export {
  BufferAttribute, BufferGeometry, CapsuleGeometry, Color, ConeGeometry, DirectionalLight, GridHelper, Group,
  HemisphereLight, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial,
  MeshStandardMaterial, PerspectiveCamera, Points, PointsMaterial, Quaternion, Scene, SphereGeometry, Vector3,
  WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
