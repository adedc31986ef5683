// The live arm in a page that is read: what is drawn comes with the element, as Python wrote it.

import { type JSX, render } from "preact";

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

/** Puts an arm into every element that tells one. */
export function showArms(): void {
  for (const element of document.querySelectorAll<HTMLElement>("[data-arm]")) {
    fill(element, element.dataset["arm"]!, (told) => <Arm {...told} language={language()} />);
  }
  for (const element of document.querySelectorAll<HTMLElement>("[data-hero]")) {
    fill(element, element.dataset["hero"]!, (told) => <Hero robot={told.robot} language={language()} />);
  }
}

function fill(element: HTMLElement, text: string, shown: (told: Told) => JSX.Element): void {
  element.textContent = "";
  element.lang = chosenLanguage();
  render(shown(JSON.parse(text) as Told), element);
}
