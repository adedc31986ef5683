// The spatial arm as a solid body, by three.js: loaded only where a spatial arm is shown, drawn only when it changes.

import * as THREE from "three";

import { type Arm, reachOf, type State } from "./model.js";
import { extentOf, thicknessOf } from "./ranges.js";
import { bodyOf, linkOf, placesOf } from "./shape.js";
import { right } from "./svd.js";
import { along, norm, scaled, subtract, unit, type Vec3 } from "./vector.js";
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
  draw(arm: Arm, state: State, view: View, columns: readonly Vec3[] | null, palette: Palette): void;
  dispose(): void;
}

const UP = new THREE.Vector3(0, 1, 0);
const SIDES = 40;
/** More solids of one kind than the links and joints of any arm take. */
const MOST_PIECES = 100;

/** Unit solids, each of which stands in the arm many times. */
type Solid = "bar" | "ball" | "box";

/** A solid where it stands, how large and in which colour. */
type Piece = { readonly solid: Solid; readonly place: THREE.Matrix4; readonly color: string };

/** A stage on a canvas. Throws where the browser has no WebGL. */
export function stageOn(canvas: HTMLCanvasElement): Stage {
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
  const scene = new THREE.Scene();
  const camera = new THREE.OrthographicCamera();
  const sun = new THREE.DirectionalLight(0xffffff, 1.6);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8890a0, 1.7), sun, sun.target);
  const ball = new THREE.SphereGeometry(1, 28, 18);
  const solids: Readonly<Record<Solid, THREE.InstancedMesh>> = {
    bar: copiesIn(scene, new THREE.CylinderGeometry(1, 1, 1, SIDES)),
    ball: copiesIn(scene, ball),
    box: copiesIn(scene, new THREE.BoxGeometry(1, 1, 1)),
  };
  const glass = new THREE.MeshStandardMaterial({ transparent: true, opacity: 0.22, depthWrite: false });
  const ellipsoid = new THREE.Mesh(ball, glass);
  ellipsoid.matrixAutoUpdate = false;
  ellipsoid.frustumCulled = false; // its place is in its matrix alone
  scene.add(ellipsoid);
  const lines = new THREE.LineBasicMaterial();
  let grid: { readonly arm: Arm; readonly lines: THREE.PolarGridHelper } | null = null;
  let size = "";

  /** The grid under an arm, made anew for another arm only. */
  function ground(arm: Arm): void {
    if (grid?.arm === arm) return;
    if (grid) scene.remove(grid.lines);
    grid?.lines.geometry.dispose();
    grid = { arm, lines: gridUnder(arm, lines) };
    scene.add(grid.lines);
  }

  /** Room for the pixels of a view: what is drawn is lost where it is asked for, so that it is asked for once. */
  function fit({ width, height }: View): void {
    const ratio = Math.min(2, globalThis.devicePixelRatio || 1);
    const wanted = `${width} ${height} ${ratio}`;
    if (size === wanted) return;
    size = wanted;
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
  }

  return {
    draw(arm, state, view, columns, palette) {
      const pieces = piecesOf(arm, state, palette);
      for (const [solid, copies] of Object.entries(solids))
        lay(
          copies,
          pieces.filter((piece) => piece.solid === solid),
        );
      ellipsoid.visible = columns !== null;
      if (columns) ellipsoid.matrix.copy(ellipsoidAt(state, columns));
      glass.color.set(palette.ellipse);
      lines.color.set(palette.grid);
      ground(arm);
      fit(view);
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
    dispose() {
      renderer.dispose();
    },
  };
}

/** A solid that is drawn in many places at once. */
function copiesIn(scene: THREE.Scene, solid: THREE.BufferGeometry): THREE.InstancedMesh {
  const matt = new THREE.MeshStandardMaterial({ roughness: 0.75, metalness: 0 });
  const copies = new THREE.InstancedMesh(solid, matt, MOST_PIECES);
  copies.frustumCulled = false; // all of the arm is in view, and where it is changes
  scene.add(copies);
  return copies;
}

/** Put the copies of a solid where its pieces are. */
function lay(copies: THREE.InstancedMesh, pieces: readonly Piece[]): void {
  const paint = new THREE.Color();
  copies.count = pieces.length;
  pieces.forEach(({ place, color }, i) => {
    copies.setMatrixAt(i, place);
    copies.setColorAt(i, paint.set(color));
  });
  copies.instanceMatrix.needsUpdate = true;
  if (copies.instanceColor) copies.instanceColor.needsUpdate = true;
}

/** The arm as solids: bars with round ends for its links, a body for each joint, a ball for the point. */
function piecesOf(arm: Arm, state: State, palette: Palette): Piece[] {
  const joint = thicknessOf(arm);
  const thin = 0.48 * joint;
  const places = placesOf(arm, state, reachOf(arm));
  return [
    ...arm.joints.flatMap((_, i) =>
      linkOf(arm, state, i + 1).flatMap((corner, k, line) => [
        round(corner, thin, palette.link),
        ...(k > 0 ? between("bar", line[k - 1]!, corner, thin, palette.link) : []),
      ]),
    ),
    ...arm.joints.flatMap(({ kind }, i) => {
      const [low, high] = bodyOf(arm, state, i, places[i]!);
      const color = palette.joints[i % palette.joints.length]!;
      return kind === "R" ? between("bar", low, high, joint, color) : between("box", low, high, 1.7 * joint, color);
    }),
    round(state.point, 0.6 * joint, palette.link),
  ];
}

/** A unit solid that stands between two points, of a radius; nothing where they are one. */
function between(solid: "bar" | "box", a: Vec3, b: Vec3, radius: number, color: string): Piece[] {
  const way = subtract(b, a);
  const length = norm(way);
  if (length < 1e-9) return [];
  const turn = new THREE.Quaternion().setFromUnitVectors(UP, new THREE.Vector3(...unit(way)));
  const size = new THREE.Vector3(radius, length, radius);
  return [{ solid, place: new THREE.Matrix4().compose(new THREE.Vector3(...along(a, way, 0.5)), turn, size), color }];
}

function round([x, y, z]: Vec3, radius: number, color: string): Piece {
  return { solid: "ball", place: new THREE.Matrix4().makeScale(radius, radius, radius).setPosition(x, y, z), color };
}

/** The unit ball as the ellipsoid {J q : |q| = 1} at the point. */
function ellipsoidAt(state: State, columns: readonly Vec3[]): THREE.Matrix4 {
  const { sigma, v } = right(columns);
  const [a, b, c] = v.map((axis, k) =>
    new THREE.Vector3(...axis).multiplyScalar(Math.max(sigma[k]!, 1e-3 * sigma[0]!)),
  );
  return new THREE.Matrix4().makeBasis(a!, b!, c!).setPosition(...state.point);
}

/** Rings and rays on the plane of the base, which show where in space the arm stands. */
function gridUnder(arm: Arm, paint: THREE.LineBasicMaterial): THREE.PolarGridHelper {
  const { o, x, y, z } = arm.base;
  const grid = new THREE.PolarGridHelper(extentOf(arm).around, 12, 4, 96);
  grid.material = paint;
  grid.matrixAutoUpdate = false;
  const [across, up, toward] = [x, z, scaled(y, -1)].map((axis) => new THREE.Vector3(...axis));
  grid.matrix.makeBasis(across!, up!, toward!).setPosition(...o);
  return grid;
}
