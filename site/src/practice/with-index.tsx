// The bank's index on a page: that it is loading, why it could not be loaded, or what is shown of it.

import type { JSX } from "preact";
import { useEffect, useState } from "preact/hooks";

import type { Index } from "../bank.js";
import { loadIndex } from "../load.js";
import { say } from "../text/text.js";
import { Failed } from "./current.js";

interface WithIndexProps {
  readonly children: (index: Index) => JSX.Element;
  /** What is shown while the index is loaded, if that is more than a line. */
  readonly loading?: JSX.Element;
}

export function WithIndex({ children, loading }: WithIndexProps): JSX.Element {
  const [index, setIndex] = useState<Index | null>(null);
  const [failed, setFailed] = useState("");
  const load = (): void => {
    setFailed("");
    loadIndex().then(setIndex, (error: unknown) => setFailed(String(error)));
  };
  useEffect(load, []);
  if (failed) return <Failed why={failed} onAgain={load} />;
  if (index) return children(index);
  return (
    loading ?? (
      <p role="status" class="loading">
        {say("practice.loading")}
      </p>
    )
  );
}
