// The script of a package for learning platforms: a round with the student's own arms, told to the platform by SCORM.
import "../site.css";

import { type JSX, render } from "preact";
import { useEffect, useState } from "preact/hooks";

import type { Index } from "../bank.js";
import { loadIndex } from "../load.js";
import { Failed } from "../practice/current.js";
import { storage } from "../practice/storage.js";
import { chosenLanguage, loadLanguage } from "../text/languages.js";
import { ENGLISH, message, say, speak } from "../text/text.js";
import { type PackageSet, roundOf } from "./places.js";
import { inBrowser } from "./recipient.js";
import { type Above, platform, type Version } from "./scorm.js";
import { RoundView } from "./view.js";

/** The set of a package, and how its platform is spoken to. */
interface Packed extends PackageSet {
  readonly scorm: Version;
}

function Package({ set }: { set: Packed }): JSX.Element {
  const [index, setIndex] = useState<Index | null>(null);
  const [failed, setFailed] = useState("");
  const [there] = useState(() => platform(set.scorm, window as unknown as Above));
  const load = () => {
    setFailed("");
    loadIndex().then(setIndex, (error: unknown) => setFailed(String(error)));
  };
  useEffect(load, []);
  if (failed) return <Failed why={failed} onAgain={load} />;
  if (!index)
    return (
      <p role="status" class="loading">
        {say("practice.loading")}
      </p>
    );
  const nobody = inBrowser(storage, `qdot-package ${set.key}`, message("round.no-platform"));
  return (
    <RoundView index={index} round={roundOf(set, index, there?.learner ?? "")} recipient={there ?? nobody} />
  );
}

speak(await loadLanguage().catch(() => ENGLISH));
const place = document.getElementById("package");
if (place) {
  const set = JSON.parse(place.dataset["set"]!) as Packed;
  place.textContent = "";
  document.documentElement.lang = chosenLanguage();
  render(<Package set={set} />, place);
}
