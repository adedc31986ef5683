// The live arm in a page that is read: what is drawn comes with the element, as Python wrote it.

import { render } from "preact";

import { Arm } from "../arm/panel.js";
import type { Robot, SymbolInfo } from "../bank.js";
import { chosenLanguage } from "../text/languages.js";
import { language } from "../text/text.js";
import { Hero } from "./hero.js";

/** An arm as `arm_record` of exercises/site/record.py tells it. */
export interface Told {
  readonly robot: Robot;
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
}

/** Puts an arm into an element that tells one: `data-arm` has all of the panel, `data-hero` the drawing and sliders. */
export function showArm(element: HTMLElement): void {
  const { arm, hero } = element.dataset;
  const { robot, symbols } = JSON.parse(arm ?? hero!) as Told;
  element.textContent = "";
  element.lang = chosenLanguage();
  const shown = arm ? <Arm robot={robot} symbols={symbols} language={language()} /> : null;
  render(shown ?? <Hero robot={robot} language={language()} />, element);
}
