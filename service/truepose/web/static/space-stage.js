// The stage of the space picture: camera, lights and turning by finger, mouse or keys. It draws when something
// has changed and rests otherwise, so that an old tablet stays cool.

import {
  DirectionalLight, HemisphereLight, OrbitControls, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "/static/packages/three.js";

const LENS_DEG = 40;
const FROM = new Vector3(1.3, -1.6, 0.9); // from the front, right and above
const STEP_PX = 40; // of a key
const PIXELS = 2; // at most so many of the screen's for one of the page's

export class Stage {
  constructor(host) {
    this.scene = new Scene();
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(PIXELS, window.devicePixelRatio));
    this.camera = new PerspectiveCamera(LENS_DEG, 1, 1, 100_000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.keyPanSpeed = STEP_PX;
    this.controls.listenToKeyEvents(host);
    this.controls.addEventListener("change", () => this.draw());
    const sun = new DirectionalLight(0xffffff, 1.6);
    sun.position.set(800, -1200, 2000);
    this.scene.add(new HemisphereLight(0xffffff, 0x8090a0, 1.6), sun);
    host.replaceChildren(this.renderer.domElement);
    this.sizes = new ResizeObserver(() => this.fit(host));
    this.sizes.observe(host);
  }

  look(centre_mm, reach_mm) {
    const distance = (0.9 * reach_mm) / Math.tan((LENS_DEG * Math.PI) / 360) / FROM.length();
    this.camera.position.set(...centre_mm).addScaledVector(FROM, distance);
    this.controls.target.set(...centre_mm);
    this.controls.update();
    this.draw();
  }

  fit(host) {
    this.renderer.setSize(host.clientWidth, host.clientHeight);
    this.camera.aspect = host.clientWidth / Math.max(1, host.clientHeight);
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    this.asked ??= requestAnimationFrame(() => {
      this.asked = null;
      this.renderer.render(this.scene, this.camera);
    });
  }

  close() {
    this.sizes.disconnect();
    this.controls.dispose();
    this.renderer.dispose();
  }
}
