// A button with a text, in one of the page's styles.

import type { JSX } from "preact";

interface ButtonProps {
  readonly style?: string;
  readonly text: string;
  readonly disabled?: boolean;
  readonly onClick: () => void;
}

export const Button = ({ style = "quiet", text, disabled = false, onClick }: ButtonProps): JSX.Element => (
  <button type="button" class={style} disabled={disabled} onClick={onClick}>
    {text}
  </button>
);
