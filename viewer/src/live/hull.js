// The convex hull of a few points, as gspcli/pictures/hulls.py has it: the shape of a body whose joints move.
import { cross, dot, middle, norm, sub, times } from "./vectors.js";

/** Points nearer to a plane or line than this part of the extent are in it; nearer ones are one. */
const FLAT = 2e-3;
const SAME = 1e-9;

/** The faces, each a list of corners; two points for points on a line. */
export function hull(points) {
  const offsets = points.map((p) => sub(p, middle(points)));
  const extent = Math.max(...offsets.flat().map(Math.abs));
  const far = (heights) => heights.reduce((best, x, k) => (x > heights[best] ? k : best), 0);
  const first = points[far(offsets.map(norm))];
  const second = points[far(points.map((p) => norm(sub(p, first))))];
  const along = sub(second, first);
  if (!(norm(along) > SAME * Math.max(...points.flat().map(Math.abs)))) return [];
  const aside = points.map((p) => norm(cross(along, sub(p, first))) / norm(along));
  const third = far(aside);
  if (aside[third] <= FLAT * extent) return [[first, second]];
  const normal = unit(cross(along, sub(points[third], first)));
  if (points.every((p) => Math.abs(dot(sub(p, first), normal)) <= FLAT * extent)) return [polygon(points, normal)];
  const faces = new Map();
  for (let i = 0; i < points.length; i += 1) {
    for (let j = i + 1; j < points.length; j += 1) {
      for (let k = j + 1; k < points.length; k += 1) {
        const up = cross(sub(points[j], points[i]), sub(points[k], points[i]));
        if (norm(up) <= FLAT * extent ** 2) continue;
        const heights = points.map((p) => dot(sub(p, points[i]), unit(up)));
        const outside = heights.filter((h) => Math.abs(h) > FLAT * extent);
        if (outside.some((h) => h > 0) && outside.some((h) => h < 0)) continue;
        const inside = points.filter((_, n) => Math.abs(heights[n]) <= FLAT * extent);
        const key = heights.map((h) => (Math.abs(h) <= FLAT * extent ? "1" : "0")).join("");
        if (!faces.has(key)) faces.set(key, polygon(inside, unit(up)));
      }
    }
  }
  return [...faces.values()];
}

const unit = (a) => times(1 / norm(a), a);

/** The corners, in order, of the hull of points in a plane. */
function polygon(points, normal) {
  const sizes = normal.map(Math.abs);
  const axis = [0, 0, 0].map((_, k) => (k === sizes.indexOf(Math.min(...sizes)) ? 1 : 0));
  const across = unit(cross(normal, axis));
  const up = cross(normal, across);
  const flat = points.map((p) => ({ p, x: dot(p, across), y: dot(p, up) })).sort((a, b) => a.x - b.x || a.y - b.y);
  const size = Math.max(...flat.flatMap(({ x, y }) => [Math.abs(x - flat[0].x), Math.abs(y - flat[0].y)]));
  const turn = (a, b, c) => (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  const half = (corners) => {
    const chain = [];
    for (const corner of corners) {
      while (chain.length > 1 && turn(chain.at(-2), chain.at(-1), corner) <= SAME * size ** 2) chain.pop();
      chain.push(corner);
    }
    return chain.slice(0, -1);
  };
  return [...half(flat), ...half([...flat].reverse())].map(({ p }) => p);
}
