// The stage of a live page: the followed mode solid with its constraints, the others as ghosts.
import { Quaternion } from "three";
import { buildGhost } from "../bodies.js";
import { Stage } from "../stage.js";
import { numberOf, pointAt } from "./drives.js";
import { hull } from "./hull.js";
import { cueOf } from "./mode_colours.js";
import { distance } from "./rotations.js";
import { feetAt, reaching, strokesAt } from "./strokes.js";
import { middle, norm, sub } from "./vectors.js";

const UPRIGHT = { R: [1, 0, 0, 0, 1, 0, 0, 0, 1], T: [0, 0, 0] };
const FADING = 700;
/** A ghost is as faint as one of this many poses on the page without sliders. */
const FAINT = 9;
/** So many of the other modes are the nearest. */
const NEAREST = 6;

export class LiveStage extends Stage {
  /** `drives` has of each constraint the crank or slide of its point, or null; `numbers` which value is its own. */
  constructor(canvas, labels, scene, { drives, numbers }, paint) {
    super(canvas, labels, scene);
    this.paint = paint;
    this.shades = new Map();
    this.fading = [];
    this.others = "all";
    const named = ({ elements }, name) => elements.find((element) => element.name === name);
    this.measured = scene.constraints.map(({ kind, platform, base }, k) => ({
      kind, platform: named(scene.platform, platform), base: named(scene.base, base), drive: drives[k], number: numbers[k], q: 0,
    }));
    // Every stroke that a constraint may have; where they are comes with each move.
    const strokes = this.measured.map((each) =>
      strokesAt(each, UPRIGHT, scene.size).strokes.map(({ style, points }) => ({ style, points: [points] })));
    this.live = { T: [], q: [], strokes, labels: [], measured: [], bodies: {}, parameter: null };
  }

  /** Ghosts are kept from move to move. */
  buildGhosts() {}

  /** Draw once after several changes. */
  together(change) {
    this.isHeld = true;
    change();
    this.isHeld = false;
    this.draw();
  }

  draw() {
    if (!this.isHeld) super.draw();
  }

  /** Show all modes for some values, one of them followed (or null), which measures others perhaps. */
  showModes(modes, followed, values, found) {
    this.moveJoints(values);
    const index = modes.indexOf(followed);
    const { live } = this;
    live.T = modes.map(({ T }) => Array.from(T));
    live.q = modes.map(({ q }) => q);
    live.numbers = modes.map(({ number }) => number);
    live.measured = { [index]: this.measured.map(({ number }) => (found ?? values)[number]) };
    live.labels = {};
    if (followed) {
      this.reach(followed);
      const drawn = this.measured.map((each) => strokesAt(each, followed, this.data.size));
      drawn.forEach(({ strokes }, k) => strokes.forEach(({ points }, j) => (live.strokes[k][j].points = { [index]: points })));
      live.labels[index] = drawn.map(({ label }) => label);
      this.measured.forEach(({ drive }, k) => {
        if (drive) live.measured[index][k] = norm(sub(...drawn[k].strokes[0].points));
      });
    }
    this.placeGhosts(modes, followed);
    this.show(live, followed ? index : modes.length);
  }

  /** Motors bring joints to other places of their bodies. */
  moveJoints(values) {
    const moved = new Set();
    for (const constraint of this.measured) {
      const { drive, number } = constraint;
      if (!drive) continue;
      const q = numberOf(drive, values[number]);
      if (q === constraint.q) continue;
      constraint.q = q;
      constraint[drive.body].outline = [pointAt(drive, q)];
      moved.add(drive.body);
    }
    for (const name of moved) {
      const { elements } = this.data[name];
      const joints = elements.filter(({ primitive }) => primitive !== "H").map(({ outline }) => middle(outline));
      // Another body for `useBody`.
      this.data[name] = { ...this.data[name], faces: hull(joints) };
    }
    if (moved.has("platform")) for (const [number, ghost] of this.shades) this.remove(number, ghost);
  }

  /** Planes reach to the feet on them: what is drawn of them grows with the moves. */
  reach(followed) {
    for (const constraint of this.measured) {
      const feet = feetAt(constraint, followed);
      if (!feet) continue;
      for (const name of ["platform", "base"]) {
        const outline = constraint[name].primitive === "H" ? reaching(constraint[name], feet[name], this.data.size) : null;
        if (!outline) continue;
        constraint[name].outline = outline;
        // Another body for `useBody`, of the same parts.
        this.data[name] = { ...this.data[name] };
      }
    }
  }

  placeGhosts(modes, followed) {
    const numbers = new Set(modes.map(({ number }) => number));
    for (const [number, ghost] of this.shades) if (!numbers.has(number)) this.remove(number, ghost);
    const drawn = this.drawnOthers(modes, followed);
    modes.forEach((mode, k) => {
      const ghost = this.shades.get(mode.number) ?? this.shade(mode.number);
      ghost.userData.index = k;
      ghost.visible = drawn.has(mode);
      this.place(ghost, mode.T, mode.q);
    });
  }

  /** Which modes are drawn beside the followed one. */
  drawnOthers(modes, followed) {
    this.shown = [modes, followed];
    const others = modes.filter((mode) => mode !== followed);
    if (this.others === "none") return new Set();
    if (this.others === "all") return new Set(others);
    const far = new Map(others.map((mode) => [mode, followed ? distance(mode, followed, this.data.size) : 0]));
    return new Set(others.sort((a, b) => far.get(a) - far.get(b)).slice(0, NEAREST));
  }

  /** Draw all modes beside the followed one, the nearest, or none. */
  setOthers(which) {
    this.others = which;
    if (!this.shown) return;
    this.placeGhosts(...this.shown);
    this.draw();
  }

  /** What should be in the view: what is drawn, but for modes far away. */
  wanted() {
    const drawn = this.ghosts.children.filter(({ visible }) => visible).map(({ userData }) => userData.index);
    const followed = this.index < this.live.T.length ? [this.index] : [];
    if (!drawn.length) return this.sphere(followed);
    return this.sphere([...this.near(drawn), ...followed]);
  }

  place(group, T, [w, x, y, z]) {
    group.position.copy(this.toScene(T));
    group.quaternion.copy(new Quaternion(x, y, z, w));
  }

  shade(number) {
    const ghost = buildGhost(this.data.platform, this.inBody, this.paint(number), FAINT, cueOf(number));
    ghost.userData.number = number;
    this.shades.set(number, ghost);
    this.ghosts.add(ghost);
    return ghost;
  }

  remove(number, ghost) {
    this.shades.delete(number);
    this.ghosts.remove(ghost);
    dispose(ghost);
  }

  /** Two modes that have met: both go to where they met, and fade there. */
  fade(met) {
    for (const { modes, pair } of met) {
      modes.forEach((mode, k) => {
        const ghost = buildGhost(this.data.platform, this.inBody, this.paint(mode.number), 2);
        this.scene.add(ghost);
        this.fading.push({ ghost, mode, end: pair[k], began: performance.now() });
      });
    }
    if (met.length) requestAnimationFrame(() => this.fadeOn());
  }

  fadeOn() {
    const now = performance.now();
    this.fading = this.fading.filter(({ ghost, mode, end, began }) => {
      const t = (now - began) / FADING;
      if (t >= 1) {
        ghost.removeFromParent();
        dispose(ghost);
        return false;
      }
      const eased = 1 - (1 - t) ** 2;
      this.place(ghost, Array.from(mode.T, (x, k) => x + eased * (end.T[k] - x)), mode.q);
      ghost.userData.fade(1 - t);
      return true;
    });
    this.draw();
    if (this.fading.length) requestAnimationFrame(() => this.fadeOn());
  }

  /** The number of the ghost under a point of the page, or null. */
  modeUnder(clientX, clientY) {
    const hit = this.hits(clientX, clientY, this.ghosts.children.filter(({ visible }) => visible))[0];
    return hit?.object.parent.userData.number ?? null;
  }

  /** What has been aimed at stays while the followed mode is in it: a view that jumps is no help. */
  keepInSight() {
    if (this.seen === null) {
      super.keepInSight();
      return;
    }
    const sphere = this.sphere(this.index < this.live.T.length ? [this.index] : []);
    if (sphere.center.distanceTo(this.seen.center) + sphere.radius > 1.25 * this.seen.radius) this.aim(this.wanted(), this.direction());
  }
}

function dispose(ghost) {
  ghost.traverse((part) => {
    // Rods share their geometry; the places of each are its own.
    if (part.isInstancedMesh) part.dispose();
    else part.geometry?.dispose();
    part.material?.dispose();
  });
}
