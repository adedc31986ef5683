// The script of the page of the student's own arm.
import "../site.css";

import { loadKnownArms } from "../load.js";
import { showPart } from "../pages/part.js";
import { say } from "../text/text.js";
import { OwnArm } from "./own-arm.js";

await showPart("own", ["Your own arm", "own.title"], async () => {
  const knownArms = await loadKnownArms().catch(() => null);
  return knownArms ? <OwnArm knownArms={knownArms} /> : <p role="alert">{say("practice.arm-failed")}</p>;
});
