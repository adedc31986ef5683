// The script of a package for learning platforms: a round with the student's own arms, told to the platform by SCORM.
import "../site.css";

import { type JSX, render } from "preact";
import { useState } from "preact/hooks";

import { WithIndex } from "../practice/with-index.js";
import { storage } from "../storage.js";
import { chosenLanguage, loadLanguage } from "../text/languages.js";
import { ENGLISH, message, speak } from "../text/text.js";
import { type PackageSet, roundOf } from "./places.js";
import { inBrowser } from "./recipient.js";
import { type Above, platform, type Version } from "./scorm.js";
import { RoundView } from "./view.js";

/** The set of a package, and how its platform is spoken to. */
type Packed = PackageSet & { readonly scorm: Version };

function Package({ set }: { set: Packed }): JSX.Element {
  const [there] = useState(() => platform(set.scorm, window as unknown as Above));
  const nobody = inBrowser(storage, `qdot-package ${set.key}`, message("round.no-platform"));
  return (
    <WithIndex>
      {(index) => (
        <RoundView index={index} round={roundOf(set, index, there?.learner ?? "")} recipient={there ?? nobody} />
      )}
    </WithIndex>
  );
}

speak(await loadLanguage().catch(() => ENGLISH));
const place = document.getElementById("package")!;
const set = JSON.parse(place.dataset["set"]!) as Packed;
place.textContent = "";
document.documentElement.lang = chosenLanguage();
render(<Package set={set} />, place);
