// Load something, such as the bank's index: show that it is loading, an error, or the content that needs it.

import type { JSX } from "preact";

import type { Index } from "../bank.js";
import { Failed } from "../controls.js";
import { useLoaded } from "../scheduling.js";
import { loadIndex } from "../load.js";
import { say } from "../text/text.js";

interface WithLoadedProps<T> {
  readonly load: () => Promise<T>;
  readonly children: (loaded: T) => JSX.Element;
}

export function WithLoaded<T>({ load, children }: WithLoadedProps<T>): JSX.Element {
  const { loaded, error, retry } = useLoaded(load, []);
  if (error) return <Failed reason={error} onAgain={retry} />;
  if (loaded) return children(loaded);
  return (
    <p role="status" class="loading">
      {say("practice.loading")}
    </p>
  );
}

export const WithIndex = (props: Omit<WithLoadedProps<Index>, "load">): JSX.Element => (
  <WithLoaded load={loadIndex} {...props} />
);
