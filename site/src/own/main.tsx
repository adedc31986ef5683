// The script of the page of the student's own arm.
import "../site.css";

import { loadKnownArms } from "../load.js";
import { showPart } from "../pages/part.js";
import { say } from "../text/text.js";
import { OwnArm } from "./own.js";

await showPart("own", ["Your own arm", "own.title"], async () => {
  const known = await loadKnownArms().catch(() => null);
  return known ? <OwnArm known={known} /> : <p role="alert">{say("practice.arm-failed")}</p>;
});
