// Load the bank's index: show that it is loading, an error, or the content that needs the index.

import type { JSX } from "preact";

import type { Index } from "../bank.js";
import { Failed } from "../controls.js";
import { useLoaded } from "../scheduling.js";
import { loadIndex } from "../load.js";
import { say } from "../text/text.js";

interface WithIndexProps {
  readonly children: (index: Index) => JSX.Element;
  /** Shown while the index is loaded, by default a line of text. */
  readonly loading?: JSX.Element;
}

export function WithIndex({ children, loading }: WithIndexProps): JSX.Element {
  const { loaded, error, retry } = useLoaded(loadIndex, []);
  if (error) return <Failed reason={error} onAgain={retry} />;
  if (loaded) return children(loaded);
  return (
    loading ?? (
      <p role="status" class="loading">
        {say("practice.loading")}
      </p>
    )
  );
}
