// The solid body of a spatial arm, below the drawing's lines. It is absent until three.js is loaded, and without WebGL.

import type { JSX } from "preact";
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";

import type { Arm, State } from "./model.js";
import type { Palette, SolidArm } from "./scene.js";
import { colorOf } from "./shade.js";
import type { Vec3 } from "./vector.js";
import type { View } from "./view.js";

interface SpaceProps {
  readonly arm: Arm;
  readonly state: State;
  readonly view: View;
  readonly columns: readonly Vec3[] | null;
  readonly onReady: (isReady: boolean) => void;
}

export function Space({ arm, state, view, columns, onReady }: SpaceProps): JSX.Element {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [solidArm, setSolidArm] = useState<SolidArm | null>(null);
  const [schemeChanges, setSchemeChanges] = useState(0);

  useEffect(() => {
    let isUnmounted = false;
    let createdArm: SolidArm | null = null;
    void import("./scene.js")
      .then(({ createSolidArm }) => {
        if (isUnmounted || !canvas.current) return;
        createdArm = createSolidArm(canvas.current);
        setSolidArm(createdArm);
        onReady(true);
      })
      .catch(() => onReady(false));
    return () => {
      isUnmounted = true;
      createdArm?.dispose();
    };
  }, []);

  useEffect(() => onSchemeChange(() => setSchemeChanges((count) => count + 1)), []);

  const palette = useMemo(() => canvas.current && paletteOf(canvas.current), [solidArm, schemeChanges]);

  // In the same frame as the lines over it.
  useLayoutEffect(() => {
    if (solidArm && palette) solidArm.draw(arm, state, view, columns, palette);
  }, [solidArm, palette, arm, state, view, columns]);

  return <canvas ref={canvas} class="arm-canvas" aria-hidden="true" />;
}

/** Call back when the page becomes light or dark, by the system's setting or by a theme set on the root element. */
export function onSchemeChange(callback: () => void): () => void {
  const systemDark = matchMedia("(prefers-color-scheme: dark)");
  const themeObserver = new MutationObserver(callback);
  systemDark.addEventListener("change", callback);
  themeObserver.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme", "class"] });
  return () => {
    systemDark.removeEventListener("change", callback);
    themeObserver.disconnect();
  };
}

function paletteOf(element: HTMLElement): Palette {
  const color = (name: string): string => colorOf(element, `--arm-${name}`);
  return {
    link: color("solid"),
    grid: color("grid"),
    ellipse: color("ellipse"),
    joints: [1, 2, 3, 4, 5, 6, 7].map((i) => color(`joint-${i}`)),
  };
}
