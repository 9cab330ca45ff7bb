// The stage of the space picture: camera, lights and turning by finger, mouse or keys. It draws when something
// has changed and rests otherwise, so that an old tablet stays cool. While somebody turns it, it is as sharp as twenty
// pictures a second allow; at rest it is sharp.

import {
  DirectionalLight, HemisphereLight, OrbitControls, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "/static/packages/three.js";

const LENS_DEG = 40;
const FROM = new Vector3(1.3, -1.6, 0.9); // from the front, right and above
const STEP_PX = 40; // of a key
const PIXELS = 2; // for one of the page's, at rest: on a coarse screen that smooths the edges
const SLOW_MS = 45; // from one picture to the next
const COARSER = { by: 0.5, least: 0.5 }; // pixels of a picture that comes too slowly

export class Stage {
  constructor(host) {
    this.scene = new Scene();
    this.pixels = PIXELS;
    this.turned = Math.min(PIXELS, window.devicePixelRatio); // pixels while it is turned
    this.renderer = new WebGLRenderer({ antialias: false, alpha: true });
    this.renderer.setPixelRatio(this.pixels);
    this.camera = new PerspectiveCamera(LENS_DEG, 1, 1, 100_000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.keyPanSpeed = STEP_PX;
    this.controls.listenToKeyEvents(host);
    this.controls.addEventListener("change", () => this.draw());
    this.controls.addEventListener("start", () => this.turn(true));
    this.controls.addEventListener("end", () => this.turn(false));
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
    this.asked ??= requestAnimationFrame((begun) => {
      this.asked = null;
      // A canvas of another size is empty: it is drawn on at once.
      if (this.renderer.getPixelRatio() !== this.pixels) this.renderer.setPixelRatio(this.pixels);
      this.renderer.render(this.scene, this.camera);
      if (this.turning) requestAnimationFrame((next) => this.pace(next - begun));
    });
  }

  pace(took_ms) {
    this.slow = took_ms > SLOW_MS ? (this.slow ?? 0) + 1 : 0;
    if (!this.turning || this.slow < 2) return; // once is chance
    this.slow = 0;
    this.turned = Math.max(COARSER.least, COARSER.by * this.turned);
    this.pixels = this.turned;
  }

  turn(turning) {
    this.turning = turning;
    this.pixels = turning ? this.turned : PIXELS;
    this.draw();
  }

  close() {
    this.sizes.disconnect();
    this.controls.dispose();
    this.renderer.dispose();
  }
}
