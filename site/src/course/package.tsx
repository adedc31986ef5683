// The script of a SCORM package: a round with the student's own arms, reported to the learning platform.
import "../site.css";

import { type JSX, render } from "preact";
import { useState } from "preact/hooks";

import { WithIndex } from "../practice/with-index.js";
import { storage } from "../storage.js";
import { getLanguageCode, loadLanguage } from "../text/languages.js";
import { ENGLISH, message, setLanguage } from "../text/text.js";
import { type PackageSet, selectRound } from "./package-set.js";
import { makeBrowserRecipient } from "./recipient.js";
import { type WindowNode, connect, type Version } from "./scorm.js";
import { RoundView } from "./view.js";

/** The set of a package, and the version of SCORM for its platform. */
type ScormSet = PackageSet & { readonly scorm: Version };

function Package({ set }: { set: ScormSet }): JSX.Element {
  const [platform] = useState(() => connect(set.scorm, window as unknown as WindowNode));
  const browserOnly = makeBrowserRecipient(storage, `qdot-package ${set.key}`, message("round.no-platform"));
  return (
    <WithIndex>
      {(index) => (
        <RoundView
          index={index}
          round={selectRound(set, index, platform?.learner ?? "")}
          recipient={platform ?? browserOnly}
        />
      )}
    </WithIndex>
  );
}

setLanguage(await loadLanguage().catch(() => ENGLISH));
const place = document.getElementById("package")!;
const set = JSON.parse(place.dataset["set"]!) as ScormSet;
place.textContent = "";
document.documentElement.lang = getLanguageCode();
render(<Package set={set} />, place);
