// Links to the questions of a set, each with a mark that shows its state.

import type { JSX } from "preact";

import { message, say } from "../text/text.js";

/** How a question is marked: by a text as well as a colour. */
const MARK_TEXTS = {
  open: "round.open",
  right: "practice.right",
  partial: "practice.partly",
  wrong: "practice.wrong",
} as const;
export type Mark = keyof typeof MARK_TEXTS;

interface PlacesProps {
  readonly places: readonly { readonly number: string; readonly mark: Mark }[];
  /** The index of the question that is shown. */
  readonly place: number;
  readonly onPlace: (place: number) => void;
}

export const Places = ({ places, place, onPlace }: PlacesProps): JSX.Element => (
  <ol class="round-places">
    {places.map(({ number, mark }, i) => (
      <li key={number}>
        <button
          type="button"
          class={mark}
          aria-current={i === place ? "true" : undefined}
          aria-label={say("round.place", { number, state: message(MARK_TEXTS[mark]) })}
          onClick={() => onPlace(i)}
        >
          {number}
        </button>
      </li>
    ))}
  </ol>
);
