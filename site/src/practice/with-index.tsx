// The bank's index on a page: that it is loading, why it could not be loaded, or what is shown of it.

import type { JSX } from "preact";

import type { Index } from "../bank.js";
import { useLoaded } from "../later.js";
import { loadIndex } from "../load.js";
import { say } from "../text/text.js";
import { Failed } from "./current.js";

interface WithIndexProps {
  readonly children: (index: Index) => JSX.Element;
  /** What is shown while the index is loaded, if that is more than a line. */
  readonly loading?: JSX.Element;
}

export function WithIndex({ children, loading }: WithIndexProps): JSX.Element {
  const { found, failed, again } = useLoaded(loadIndex, []);
  if (failed) return <Failed why={failed} onAgain={again} />;
  if (found) return children(found);
  return (
    loading ?? (
      <p role="status" class="loading">
        {say("practice.loading")}
      </p>
    )
  );
}
