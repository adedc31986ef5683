// The spatial arm as a solid body, by three.js; loaded only for a spatial arm, drawn only when it changes.

import * as THREE from "three";

import { type Arm, reachOf, type State } from "./model.js";
import { extentOf, thicknessOf } from "./ranges.js";
import { bodyOf, linkOf, jointCentresOf } from "./shape.js";
import { drawingScale } from "./size.js";
import { decompose } from "./svd.js";
import { addScaled, norm, scaleVector, subtract, unit, type Vec3 } from "./vector.js";
import type { View } from "./view.js";

/** Colours as CSS writes them. */
export interface Palette {
  readonly link: string;
  readonly grid: string;
  readonly ellipse: string;
  readonly joints: readonly string[];
}

/** A solid arm on a canvas. */
export interface SolidArm {
  /** Draw an arm, and the ellipsoid of velocities of P from the columns of J; null columns hide the ellipsoid. */
  draw(arm: Arm, state: State, view: View, columns: readonly Vec3[] | null, palette: Palette): void;
  dispose(): void;
}

const UP = new THREE.Vector3(0, 1, 0);
const SIDES_OF_CYLINDER = 40;
/** More solids of one kind than any arm needs. */
const MAX_PIECES = 100;

/** Unit solids, of which the arm has many copies. */
type Solid = "bar" | "ball" | "box";

/** A copy of a solid: its position and size as a matrix, and its colour. */
type SolidPiece = { readonly solid: Solid; readonly matrix: THREE.Matrix4; readonly color: string };

/** Return a solid arm on a canvas. Throws if the browser has no WebGL. */
export function createSolidArm(canvas: HTMLCanvasElement): SolidArm {
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
  const scene = new THREE.Scene();
  const camera = new THREE.OrthographicCamera();
  const sun = new THREE.DirectionalLight(0xffffff, 1.6);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8890a0, 1.7), sun, sun.target);
  const ball = new THREE.SphereGeometry(1, 28, 18);
  const solids: Readonly<Record<Solid, THREE.InstancedMesh>> = {
    bar: copiesIn(scene, new THREE.CylinderGeometry(1, 1, 1, SIDES_OF_CYLINDER)),
    ball: copiesIn(scene, ball),
    box: copiesIn(scene, new THREE.BoxGeometry(1, 1, 1)),
  };
  const glass = new THREE.MeshStandardMaterial({ transparent: true, opacity: 0.22, depthWrite: false });
  const ellipsoid = new THREE.Mesh(ball, glass);
  ellipsoid.matrixAutoUpdate = false;
  ellipsoid.frustumCulled = false; // its position is only in its matrix
  scene.add(ellipsoid);
  const gridMaterial = new THREE.LineBasicMaterial();
  let grid: { readonly arm: Arm; readonly lines: THREE.PolarGridHelper } | null = null;
  let fittedSize = "";

  /** Put the grid under an arm; a new grid is made only for another arm. */
  function placeGrid(arm: Arm): void {
    if (grid?.arm === arm) return;
    if (grid) scene.remove(grid.lines);
    grid?.lines.geometry.dispose();
    grid = { arm, lines: gridUnder(arm, gridMaterial) };
    scene.add(grid.lines);
  }

  /** Fit the renderer to the pixels of a view. Resizing clears the canvas, so it happens only if the size changed. */
  function fitRenderer({ width, height }: View): void {
    const ratio = Math.min(2, globalThis.devicePixelRatio || 1) * drawingScale();
    const size = `${width} ${height} ${ratio}`;
    if (size === fittedSize) return;
    fittedSize = size;
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
  }

  return {
    draw(arm, state, view, columns, palette) {
      const pieces = piecesOf(arm, state, palette);
      for (const [solid, copies] of Object.entries(solids))
        placeCopies(
          copies,
          pieces.filter((piece) => piece.solid === solid),
        );
      ellipsoid.visible = columns !== null;
      if (columns) ellipsoid.matrix.copy(ellipsoidAt(state, columns));
      glass.color.set(palette.ellipse);
      gridMaterial.color.set(palette.grid);
      placeGrid(arm);
      fitRenderer(view);
      const [halfWidth, halfHeight, distance] = [
        view.width / view.scale / 2,
        view.height / view.scale / 2,
        20 * reachOf(arm),
      ];
      Object.assign(camera, {
        left: -halfWidth,
        right: halfWidth,
        top: halfHeight,
        bottom: -halfHeight,
        near: 0,
        far: 2 * distance,
      });
      camera.position.set(...addScaled(view.centre, view.towardReader, distance));
      camera.up.set(...view.up);
      camera.lookAt(...view.centre);
      camera.updateProjectionMatrix();
      const toLight = addScaled(addScaled(view.towardReader, view.up, 1.1), view.right, -0.6); // from above, left
      sun.position.set(...addScaled(view.centre, toLight, distance));
      sun.target.position.set(...view.centre);
      renderer.render(scene, camera);
    },
    dispose() {
      renderer.dispose();
    },
  };
}

/** Return an instanced mesh of a solid, added to the scene. */
function copiesIn(scene: THREE.Scene, solid: THREE.BufferGeometry): THREE.InstancedMesh {
  const material = new THREE.MeshStandardMaterial({ roughness: 0.75, metalness: 0 });
  const copies = new THREE.InstancedMesh(solid, material, MAX_PIECES);
  copies.frustumCulled = false; // the whole arm is always in view
  scene.add(copies);
  return copies;
}

/** Put the copies of a solid where its pieces are. */
function placeCopies(copies: THREE.InstancedMesh, pieces: readonly SolidPiece[]): void {
  const paint = new THREE.Color();
  copies.count = pieces.length;
  pieces.forEach(({ matrix, color }, i) => {
    copies.setMatrixAt(i, matrix);
    copies.setColorAt(i, paint.set(color));
  });
  copies.instanceMatrix.needsUpdate = true;
  if (copies.instanceColor) copies.instanceColor.needsUpdate = true;
}

/** Return the arm as solids: bars with round ends for its links, a body for each joint, a ball for P. */
function piecesOf(arm: Arm, state: State, palette: Palette): SolidPiece[] {
  const jointRadius = thicknessOf(arm);
  const linkRadius = 0.48 * jointRadius;
  const jointCentres = jointCentresOf(arm, state, reachOf(arm));
  return [
    ...arm.joints.flatMap((_, i) =>
      linkOf(arm, state, i + 1).flatMap((corner, k, line) => [
        ballAt(corner, linkRadius, palette.link),
        ...(k > 0 ? solidBetween("bar", line[k - 1]!, corner, linkRadius, palette.link) : []),
      ]),
    ),
    ...arm.joints.flatMap(({ kind }, i) => {
      const [low, high] = bodyOf(arm, state, i, jointCentres[i]!);
      const color = palette.joints[i % palette.joints.length]!;
      return kind === "R"
        ? solidBetween("bar", low, high, jointRadius, color)
        : solidBetween("box", low, high, 1.7 * jointRadius, color);
    }),
    ballAt(state.point, 0.6 * jointRadius, palette.link),
  ];
}

/** Return a bar or box between two points, of a radius; an empty list if the points coincide. */
function solidBetween(solid: "bar" | "box", a: Vec3, b: Vec3, radius: number, color: string): SolidPiece[] {
  const difference = subtract(b, a);
  const length = norm(difference);
  if (length < 1e-9) return [];
  const rotation = new THREE.Quaternion().setFromUnitVectors(UP, new THREE.Vector3(...unit(difference)));
  const size = new THREE.Vector3(radius, length, radius);
  return [
    {
      solid,
      matrix: new THREE.Matrix4().compose(new THREE.Vector3(...addScaled(a, difference, 0.5)), rotation, size),
      color,
    },
  ];
}

function ballAt([x, y, z]: Vec3, radius: number, color: string): SolidPiece {
  return { solid: "ball", matrix: new THREE.Matrix4().makeScale(radius, radius, radius).setPosition(x, y, z), color };
}

/** Return the matrix that maps the unit ball to the ellipsoid {J qdot : |qdot| = 1} at P; flat ones get some depth. */
function ellipsoidAt(state: State, columns: readonly Vec3[]): THREE.Matrix4 {
  const { sigma, v } = decompose(columns);
  const [firstAxis, b, c] = v.map((axis, k) =>
    new THREE.Vector3(...axis).multiplyScalar(Math.max(sigma[k]!, 1e-3 * sigma[0]!)),
  );
  return new THREE.Matrix4().makeBasis(firstAxis!, b!, c!).setPosition(...state.point);
}

/** Return rings and rays in the plane of the base, which show where the arm stands in space. */
function gridUnder(arm: Arm, material: THREE.LineBasicMaterial): THREE.PolarGridHelper {
  const { o, x, y, z } = arm.base;
  const grid = new THREE.PolarGridHelper(extentOf(arm).radius, 12, 4, 96);
  grid.material = material;
  grid.matrixAutoUpdate = false;
  const [right, up, front] = [x, z, scaleVector(y, -1)].map((axis) => new THREE.Vector3(...axis));
  grid.matrix.makeBasis(right!, up!, front!).setPosition(...o);
  return grid;
}
