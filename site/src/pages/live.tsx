// The live arm in a page that is read: what is drawn comes with the element, as Python wrote it.

import { type JSX, render } from "preact";

import { armOf } from "../arm/model.js";
import { Arm } from "../arm/panel.js";
import { extentOf, firstPose } from "../arm/ranges.js";
import type { Robot, SymbolInfo } from "../bank.js";
import { breath } from "../later.js";
import { chosenLanguage } from "../text/languages.js";
import { language } from "../text/text.js";
import { Hero } from "./hero.js";

/** An arm as `arm_record` of exercises/site/record.py tells it. */
export interface Told {
  readonly robot: Robot;
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
}

/** Puts an arm into an element that tells one: `data-arm` has all of the panel, `data-hero` the drawing and sliders. */
export async function showArm(element: HTMLElement): Promise<void> {
  const { arm, hero } = element.dataset;
  const { robot, symbols } = JSON.parse(arm ?? hero!) as Told;
  const shown = arm ? <Arm robot={robot} symbols={symbols} language={language()} /> : await greeting(robot);
  element.textContent = "";
  element.lang = chosenLanguage();
  render(shown, element);
}

/** The arm of the first page, worked out in steps: fingers and keys are answered meanwhile. */
async function greeting(robot: Robot): Promise<JSX.Element> {
  const arm = armOf(robot);
  await breath();
  const first = firstPose(arm);
  await breath();
  extentOf(arm); // is kept
  await breath();
  return <Hero title={robot.title} arm={arm} first={first} language={language()} />;
}
