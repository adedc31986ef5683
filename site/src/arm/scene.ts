// The spatial arm as a solid body, by three.js: loaded only where a spatial arm is shown, drawn only when it changes.

import {
  BoxGeometry,
  Color,
  CylinderGeometry,
  DirectionalLight,
  Group,
  HemisphereLight,
  LineBasicMaterial,
  LineSegments,
  BufferGeometry,
  Float32BufferAttribute,
  Matrix4,
  Mesh,
  MeshStandardMaterial,
  OrthographicCamera,
  Quaternion,
  Scene,
  SphereGeometry,
  Vector3,
  WebGLRenderer,
} from "three";

import { type Arm, reachOf, type State } from "./model.js";
import { extentOf, thicknessOf } from "./ranges.js";
import { linkOf, placesOf } from "./shape.js";
import { right } from "./svd.js";
import { along, norm, subtract, unit, type Vec3 } from "./vector.js";
import type { View } from "./view.js";

/** Colours as CSS writes them. */
export interface Palette {
  readonly link: string;
  readonly grid: string;
  readonly ellipse: string;
  readonly joints: readonly string[];
}

/** What the page holds of a scene. */
export interface Stage {
  draw(arm: Arm, state: State, view: View, columns: readonly Vec3[] | null): void;
  paint(palette: Palette): void;
  dispose(): void;
}

const UP = new Vector3(0, 1, 0);
const SIDES = 40;

/** A stage on a canvas. Throws where the browser has no WebGL. */
export function stageOn(canvas: HTMLCanvasElement, palette: Palette): Stage {
  const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
  const scene = new Scene();
  const camera = new OrthographicCamera();
  const sun = new DirectionalLight(0xffffff, 1.6);
  scene.add(new HemisphereLight(0xffffff, 0x8890a0, 1.7), sun, sun.target);
  const [bar, ball, box] = [
    new CylinderGeometry(1, 1, 1, SIDES),
    new SphereGeometry(1, 28, 18),
    new BoxGeometry(1, 1, 1),
  ];
  let paints = paintsOf(palette);
  let body = new Group();
  let grid: LineSegments | null = null;
  scene.add(body);

  /** A unit solid that stands between two points, of a radius. */
  function between(
    solid: CylinderGeometry | BoxGeometry,
    a: Vec3,
    b: Vec3,
    radius: number,
    paint: MeshStandardMaterial,
  ): void {
    const way = subtract(b, a);
    const length = norm(way);
    if (length < 1e-9) return;
    const mesh = new Mesh(solid, paint);
    mesh.position.set(...along(a, way, 0.5));
    mesh.quaternion.copy(new Quaternion().setFromUnitVectors(UP, new Vector3(...unit(way))));
    mesh.scale.set(radius, length, radius);
    body.add(mesh);
  }

  function round(at: Vec3, radius: number, paint: MeshStandardMaterial): void {
    const mesh = new Mesh(ball, paint);
    mesh.position.set(...at);
    mesh.scale.setScalar(radius);
    body.add(mesh);
  }

  function built(arm: Arm, state: State): void {
    const joint = thicknessOf(arm);
    const thin = 0.48 * joint;
    arm.joints.forEach((_, i) => {
      const line = linkOf(arm, state, i + 1);
      line.forEach((corner, k) => {
        round(corner, thin, paints.link);
        if (k > 0) between(bar, line[k - 1]!, corner, thin, paints.link);
      });
    });
    const places = placesOf(arm, state, reachOf(arm));
    arm.joints.forEach(({ kind }, i) => {
      const { z } = state.frames[i]!;
      const [half, paint] = [
        kind === "R" ? 1.25 * joint : 1.9 * joint,
        paints.joints[i % paints.joints.length]!,
      ];
      const [low, high] = [along(places[i]!, z, -half), along(places[i]!, z, half)];
      between(kind === "R" ? bar : box, low, high, kind === "R" ? joint : 1.7 * joint, paint);
    });
    round(state.point, 0.6 * joint, paints.point);
  }

  function ellipsoid(state: State, columns: readonly Vec3[]): void {
    const { sigma, v } = right(columns);
    const axes = v.map((axis, k) => axis.map((value) => value * Math.max(sigma[k]!, 1e-3 * sigma[0]!)));
    const mesh = new Mesh(ball, paints.ellipse);
    mesh.matrixAutoUpdate = false;
    const rows = [0, 1, 2].flatMap((r) => [...axes.map((axis) => axis[r]!), state.point[r]!]);
    mesh.matrix = new Matrix4().set(...(rows as unknown as Twelve), 0, 0, 0, 1);
    body.add(mesh);
  }

  return {
    draw(arm, state, view, columns) {
      scene.remove(body);
      body = new Group();
      scene.add(body);
      built(arm, state);
      if (columns) ellipsoid(state, columns);
      if (!grid) scene.add((grid = gridUnder(arm, paints.grid)));
      const ratio = Math.min(2, globalThis.devicePixelRatio || 1);
      renderer.setPixelRatio(ratio);
      renderer.setSize(view.width, view.height, false);
      const [w, h, far] = [view.width / view.scale / 2, view.height / view.scale / 2, 20 * reachOf(arm)];
      Object.assign(camera, { left: -w, right: w, top: h, bottom: -h, near: 0, far: 2 * far });
      camera.position.set(...along(view.centre, view.toward, far));
      camera.up.set(...view.up);
      camera.lookAt(...view.centre);
      camera.updateProjectionMatrix();
      const light = along(along(view.toward, view.up, 1.1), view.right, -0.6);
      sun.position.set(...along(view.centre, light, far));
      sun.target.position.set(...view.centre);
      renderer.render(scene, camera);
    },
    paint(next) {
      paints = paintsOf(next);
      if (grid) scene.remove(grid);
      grid = null;
    },
    dispose() {
      renderer.dispose();
    },
  };
}

type Twelve = [
  number,
  number,
  number,
  number,
  number,
  number,
  number,
  number,
  number,
  number,
  number,
  number,
];

interface Paints {
  readonly link: MeshStandardMaterial;
  readonly point: MeshStandardMaterial;
  readonly ellipse: MeshStandardMaterial;
  readonly joints: readonly MeshStandardMaterial[];
  readonly grid: LineBasicMaterial;
}

function paintsOf({ link, grid, ellipse, joints }: Palette): Paints {
  const paint = (color: string): MeshStandardMaterial =>
    new MeshStandardMaterial({ color: new Color(color), roughness: 0.75, metalness: 0 });
  const glass = new MeshStandardMaterial({
    color: new Color(ellipse),
    transparent: true,
    opacity: 0.22,
    depthWrite: false,
  });
  return {
    link: paint(link),
    point: paint(link),
    ellipse: glass,
    joints: joints.map(paint),
    grid: new LineBasicMaterial({ color: new Color(grid) }),
  };
}

/** Rings and rays on the plane of the base, which show where in space the arm stands. */
function gridUnder(arm: Arm, paint: LineBasicMaterial): LineSegments {
  const { around } = extentOf(arm);
  const { o, x, y } = arm.base;
  const ends: number[] = [];
  const at = (radius: number, turn: number): Vec3 =>
    along(along(o, x, radius * Math.cos(turn)), y, radius * Math.sin(turn));
  for (const share of [0.25, 0.5, 0.75, 1]) {
    for (let k = 0; k < 96; k += 1) {
      ends.push(...at(share * around, (k * Math.PI) / 48), ...at(share * around, ((k + 1) * Math.PI) / 48));
    }
  }
  for (let k = 0; k < 12; k += 1)
    ends.push(...at(0.25 * around, (k * Math.PI) / 6), ...at(around, (k * Math.PI) / 6));
  const lines = new BufferGeometry();
  lines.setAttribute("position", new Float32BufferAttribute(ends, 3));
  return new LineSegments(lines, paint);
}
