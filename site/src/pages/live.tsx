// The live arm in a page that is read: what is drawn comes with the element, as Python wrote it.

import { type JSX, render } from "preact";

import { Arm } from "../arm/panel.js";
import type { Factor, NamedPose, Robot, SymbolInfo } from "../bank.js";
import { chosenLanguage } from "../text/languages.js";
import { Hero } from "./hero.js";

/** An arm as `arm_record` of exercises/site/record.py tells it. */
export interface Told {
  readonly robot: Robot;
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
  readonly pose: NamedPose;
  readonly factors?: readonly Factor[];
}

/** Show the arm that an element describes: `data-arm` with all of the stage, `data-hero` as drawing and numbers. */
export function showArm(element: HTMLElement): void {
  const { arm, hero } = element.dataset;
  const { robot, symbols, pose, factors } = JSON.parse(arm ?? hero!) as Told;
  const wish = { robot, first: pose, factors };
  const shown: JSX.Element = arm ? <Arm {...wish} symbols={symbols} pane="joints" /> : <Hero {...wish} />;
  element.textContent = "";
  element.lang = chosenLanguage();
  render(shown, element);
}
