// The movable arm, loaded once the words beside it are on the page.

import { useEffect, useState } from "preact/hooks";

import type * as Panel from "../arm/panel.js";
import { say } from "../text/text.js";

/** The movable arm; or a message if it could not be loaded, because practice works without it. */
type ArmPart = typeof Panel.Arm | typeof NoArm;
let armComponent: ArmPart | null = null;

/** Return the movable arm once it is wanted and loaded, else null. */
export function useArm(isWanted: boolean): ArmPart | null {
  const [, setLoaded] = useState(armComponent !== null);
  useEffect(() => {
    if (!isWanted || armComponent !== null) return;
    let isMounted = true;
    void import("../arm/panel.js")
      .then(
        ({ Arm }) => (armComponent = Arm),
        () => (armComponent = NoArm),
      )
      .then(() => isMounted && setLoaded(true));
    return () => void (isMounted = false);
  }, [isWanted]);
  return isWanted ? armComponent : null;
}

const NoArm = () => (
  <p role="status" class="stage-failed">
    {say("practice.arm-failed")}
  </p>
);
