// The picture: bodies, constraints, light, camera.
import {
  AmbientLight,
  DirectionalLight,
  Group,
  PerspectiveCamera,
  Quaternion,
  Raycaster,
  Scene,
  Sphere,
  SRGBColorSpace,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { buildBody, buildGhost } from "./bodies.js";
import { Bond } from "./bonds.js";
import { buildFrame } from "./frames.js";
import { Labels } from "./labels.js";
import { colour, isDark } from "./theme.js";

const VIEWS = {
  top: new Vector3(0, -0.0001, 1),
  front: new Vector3(0, -1, 0.0001),
  side: new Vector3(1, -0.0001, 0.0001),
}; const MOST_GHOSTS = 64; /** Poses that need a wider view than this are not for looking at
together with the others. */ const NEAR = 2.5; /** A pose that needs less than this part of the view
gets one of its own. */ const TOO_SMALL = 0.45; /** Pixels at each edge of the picture that are
reserved for names. */ const EDGE = 26;

export class Stage {
  constructor(canvas, labelHome, scene) {
    this.canvas = canvas;
    this.data = scene;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: false });
    this.renderer.outputColorSpace = SRGBColorSpace;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(28, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.labels = new Labels(labelHome);
    this.raycaster = new Raycaster();
    this.bonds = [];
    this.ghosts = new Group();
    this.platformColour = null;
    this.usual = new Vector3(...scene.eye);
    this.build();
  }

  // The scene is drawn in units of its size, about the middle of the base.
  build() {
    const { size, base, platform } = this.data;
    const points = base.elements.flatMap((element) => element.outline);
    const middle = points
      .reduce((sum, p) => sum.add(new Vector3(...p)), new Vector3())
      .divideScalar(points.length);
    this.middle = middle;
    this.toScene = (p) => new Vector3((p[0] - middle.x) / size, (p[1] - middle.y) / size, (p[2] - middle.z) / size);
    const inBody = (p) => new Vector3(p[0] / size, p[1] / size, p[2] / size);

    this.light = new AmbientLight(0xffffff, 1.5);
    this.lamp = new DirectionalLight(0xffffff, 1.9);
    this.scene.add(this.light, this.lamp);

    this.inBody = inBody;
    this.base = this.bodyOf("base", base);
    this.platform = this.bodyOf("platform", platform);
    this.scene.add(this.base.group, this.platform.group, this.ghosts);

    this.bonds = this.data.constraints.map((constraint) => {
      const bond = new Bond(constraint, size, { main: colour("distance"), mark: colour("mark") });
      this.scene.add(bond.group);
      return bond;
    });
    this.frames = {
      base: buildFrame(this.scene, this.toScene([0, 0, 0]), this.labels),
      platform: buildFrame(this.platform.group, new Vector3(), this.labels),
    };
    this.buildLabels();
  }

  bodyOf(name, data) {
    const place = name === "base" ? this.toScene : this.inBody;
    return { ...buildBody(name, data, place, { body: colour(name) }, this.shell(name)), data };
  }

  /** The faces of the outline that the file states of a body. */
  shell(name) {
    return this.data.shells?.[name] ?? [];
  }

  /** How a body is at a pose: where primitives move in it, another one at each. */
  bodyAt(name, index) {
    return this.series?.bodies[name]?.[index] ?? this.data[name];
  }

  /** Show a body as it is at a pose. */
  useBody(name, index) {
    const data = this.bodyAt(name, index);
    const before = this[name];
    if (before.data === data) return;
    this[name] = this.bodyOf(name, data);
    this.scene.add(this[name].group);
    if (name === "platform") this[name].group.add(this.frames.platform);
    before.group.removeFromParent();
    before.group.traverse((part) => {
      // Rods share their geometry; the places of each are its own.
      if (part.isInstancedMesh) part.dispose();
      else part.geometry?.dispose();
      part.material?.dispose();
    });
  }

  buildLabels() {
    for (const name of ["base", "platform"]) {
      this[name].labels.forEach(({ text, className }, k) => {
        this.labels.add(text, className, () => {
          const { group, labels } = this[name];
          return group.visible ? group.localToWorld(labels[k].at.clone()) : null;
        });
      });
    }
    this.numbers = this.data.constraints.map((constraint, k) =>
      this.labels.add(
        String(constraint.number),
        `bond${constraint.kind.startsWith("A") ? " angle" : ""}`,
        () => (this.series?.labels[this.index] ? this.toScene(this.series.labels[this.index][k]) : null),
        "on",
      ),
    );
  }

  show(series, index) {
    if (series !== this.series) {
      this.series = series;
      this.data.constraints.forEach((_, k) => this.bonds[k].use(series.strokes[k], { bond: k }));
      this.buildGhosts();
      this.seen = null;
    }
    this.index = index;
    for (const name of ["base", "platform"]) this.useBody(name, index);
    const exists = index < series.T.length;
    this.platform.group.visible = exists;
    for (const bond of this.bonds) bond.group.visible = exists;
    if (exists) {
      this.placeAt(this.platform.group, index);
      for (const bond of this.bonds) bond.move(index, this.toScene);
    }
    this.keepInSight();
    this.draw();
  }

  placeAt(group, index) {
    const { T, q } = this.series;
    const [w, x, y, z] = q[index];
    group.position.copy(this.toScene(T[index]));
    group.quaternion.copy(new Quaternion(x, y, z, w));
    group.updateMatrixWorld(true);
  }

  buildGhosts() {
    this.ghosts.clear();
    const count = this.series.T.length;
    const step = Math.max(1, Math.ceil(count / MOST_GHOSTS));
    for (let k = 0; k < count; k += step) {
      const ghost = buildGhost(this.bodyAt("platform", k), this.inBody, colour("platform"), count / step);
      ghost.userData.index = k;
      this.placeAt(ghost, k);
      this.ghosts.add(ghost);
    }
  }

  /** The sphere around the base and the platform at some poses. */
  sphere(indices) {
    const corners = (name, k, place) => [
      ...this.bodyAt(name, k).elements.map(({ outline }) => outline), ...this.shell(name),
    ].flatMap((outline) => outline.map(place));
    const points = corners("base", indices[0], this.toScene);
    for (const k of indices) {
      if (this.series.bodies.base) points.push(...corners("base", k, this.toScene));
      const [w, x, y, z] = this.series.q[k];
      const turn = new Quaternion(x, y, z, w);
      const at = this.toScene(this.series.T[k]);
      for (const corner of corners("platform", k, this.inBody)) points.push(corner.clone().applyQuaternion(turn).add(at));
    }
    return new Sphere().setFromPoints(points);
  }

  /** What should be in the view: a motion as a whole, of modes the one that is shown. */
  wanted() {
    if (!this.series.T.length) return this.sphere([]);
    if (!this.series.parameter && !this.ghosts.visible) return this.sphere([this.index]);
    return this.sphere([...this.near(this.series.T.map((_, k) => k)), this.index]);
  }

  /** Those of some poses that are shown together. */
  near(indices) {
    return indices.filter((k) => this.sphere([k]).radius <= NEAR);
  }

  look(view) {
    this.aim(this.wanted(), VIEWS[view] ?? this.usual);
  }

  /** Change the view if the platform is not in it, or is lost in it. */
  keepInSight() {
    const wanted = this.wanted();
    if (this.seen === null) this.aim(wanted, this.usual);
    const gap = wanted.center.distanceTo(this.seen.center) + wanted.radius;
    if (gap > 1.1 * this.seen.radius || wanted.radius < TOO_SMALL * this.seen.radius) {
      this.aim(wanted, this.direction());
    }
  }

  direction() {
    return this.camera.position.clone().sub(this.controls.target);
  }

  aim(sphere, direction) {
    this.seen = sphere;
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).addScaledVector(direction.clone().normalize(), sphere.radius * this.away());
    this.controls.update();
    this.draw();
  }

  /** From how many radii away a sphere fills the narrower side of the picture, up to the edge for names. */
  away() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const part = Math.max(Math.min(width, height) - 2 * EDGE, EDGE) / Math.max(height, 1);
    return 1 / Math.sin(Math.atan(part * Math.tan((this.camera.fov * Math.PI) / 360)));
  }

  /** Turn by angles about the vertical and up, and come nearer by a factor. */
  turn(sideways, upwards, nearer = 1) {
    const offset = this.direction();
    const length = offset.length() / nearer;
    const azimuth = Math.atan2(offset.y, offset.x) + sideways;
    const height = Math.asin(offset.z / offset.length()) + upwards;
    const limited = Math.min(Math.max(height, -1.57), 1.57);
    offset.set(Math.cos(limited) * Math.cos(azimuth), Math.cos(limited) * Math.sin(azimuth), Math.sin(limited));
    this.camera.position.copy(this.controls.target).addScaledVector(offset, length);
    this.controls.update();
    this.draw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.renderer.setPixelRatio(devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    // What filled the picture fills the new one.
    const away = this.away();
    if (this.fitted) this.turn(0, 0, this.fitted / away);
    this.fitted = away;
    this.draw();
  }

  recolour(platformColour, chosen) {
    this.scene.background = colour("paper");
    this.light.intensity = isDark() ? 1.1 : 1.6;
    this.base.recolour(colour("base"));
    this.platform.recolour(platformColour(this.index) ?? colour("platform"));
    this.bonds.forEach((bond, k) => {
      const main = k === chosen ? "chosen-part" : bond.isAngle ? "angle" : "distance";
      bond.recolour(colour(main), colour("mark"));
      this.numbers[k].span.classList.toggle("chosen", k === chosen);
    });
    for (const ghost of this.ghosts.children) {
      ghost.userData.recolour(platformColour(ghost.userData.index) ?? colour("platform"));
    }
    this.draw();
  }

  setFrames(visible) {
    this.frames.base.visible = this.frames.platform.visible = visible;
    this.draw();
  }

  setGhosts(visible) {
    this.ghosts.visible = visible;
    if (this.series) this.keepInSight();
    this.draw();
  }

  setNames(visible) {
    this.labels.visible = visible;
    this.draw();
  }

  /** What is under a point of the page: `{bond}` or `{body, element}`, and where in the scene. */
  under(clientX, clientY) {
    const parts = [...this.base.pickable];
    if (this.platform.group.visible) {
      parts.push(...this.platform.pickable, ...this.bonds.flatMap((bond) => bond.pickable));
    }
    const hits = this.hits(clientX, clientY, parts);
    // A sheet of glass does not hide what is behind it.
    const hit = hits.find(({ object }) => !object.material.transparent) ?? hits[0];
    return hit ? { ...hit.object.userData, point: hit.point } : null;
  }

  /** What of some objects is under a point of the page, the nearest first. */
  hits(clientX, clientY, objects) {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2(((clientX - box.left) / box.width) * 2 - 1, 1 - ((clientY - box.top) / box.height) * 2);
    this.raycaster.setFromCamera(at, this.camera);
    return this.raycaster.intersectObjects(objects);
  }

  draw() {
    if (!this.series) return;
    const distance = this.direction().length();
    this.camera.near = distance / 200;
    this.camera.far = distance * 50;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.lamp.position.copy(this.camera.position).add(new Vector3(0.4, 0.2, 1).multiplyScalar(distance));
    this.lamp.target.position.copy(this.controls.target);
    this.lamp.target.updateMatrixWorld();
    this.renderer.render(this.scene, this.camera);
    this.labels.place(this.camera, this.canvas.clientWidth, this.canvas.clientHeight);
  }

  /** The picture with its labels as a PNG. */
  picture() {
    const copy = this.copy();
    return new Promise((resolve) => copy.toBlob(resolve, "image/png"));
  }

  /** The picture with its labels as another canvas, of at least twice the pixels of the page. */
  copy() {
    const ratio = Math.max(2, devicePixelRatio);
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.draw();
    const copy = document.createElement("canvas");
    copy.width = this.canvas.width;
    copy.height = this.canvas.height;
    const context = copy.getContext("2d");
    context.drawImage(this.canvas, 0, 0);
    this.labels.draw(context, copy.width / width);
    this.resize();
    return copy;
  }
}
