// Buttons, labelled menus and fields for words, as all pages have them.

import type { ComponentChildren, JSX } from "preact";
import { useId } from "preact/hooks";

import { say, type TextKey } from "./text/text.js";

interface ButtonProps {
  readonly className?: string;
  readonly text: string;
  readonly disabled?: boolean;
  readonly onClick: () => void;
}

export const Button = ({ className = "quiet", text, disabled = false, onClick }: ButtonProps): JSX.Element => (
  <button type="button" class={className} disabled={disabled} onClick={onClick}>
    {text}
  </button>
);

/** An option of a menu: its value, its text, and the language of the text if it is not the page's. */
export type Option = readonly [value: string | number, text: string, lang?: string];

export const optionsOf = (options: readonly Option[]): JSX.Element[] =>
  options.map(([value, text, lang]) => (
    <option key={value} value={value} lang={lang}>
      {text}
    </option>
  ));

interface ChoiceProps {
  readonly label: TextKey;
  readonly value: string | number;
  /** The text of a first option with the value "", such as "any arm". */
  readonly any?: TextKey;
  /** The other options. */
  readonly children: ComponentChildren;
  readonly onValue: (value: string) => void;
}

/** A menu with its label. */
export const Choice = ({ label, value, any, children, onValue }: ChoiceProps): JSX.Element => (
  <label>
    {say(label)}{" "}
    <select value={value} onChange={(event) => onValue(event.currentTarget.value)}>
      {any ? <option value="">{say(any)}</option> : null}
      {children}
    </select>
  </label>
);

interface FieldProps {
  readonly label: string;
  readonly value: string;
  readonly type?: "text" | "datetime-local";
  readonly inputMode?: "text" | "decimal";
  readonly placeholder?: string;
  readonly onValue: (value: string) => void;
}

/** A field after its label. */
export function Field({ label, type = "text", onValue, ...attributes }: FieldProps): JSX.Element {
  const id = useId();
  return (
    <>
      <label for={id}>{label}</label>
      <input
        id={id}
        type={type as "text"}
        autocomplete="off"
        onInput={({ currentTarget }) => onValue(currentTarget.value)}
        {...attributes}
      />
    </>
  );
}

/** The message that something could not be loaded, with a button that tries again. */
export const Failed = ({ reason, onAgain }: { reason: string; onAgain: () => void }): JSX.Element => (
  <div role="alert">
    <p>{reason}</p>
    <Button className="button" text={say("practice.again")} onClick={onAgain} />
  </div>
);

/** A warning before something is submitted, with buttons that submit it or don't. */
export const Warning = ({ text, onSubmit, onCancel }: WarningProps): JSX.Element => (
  <div role="alert" class="verdict partial">
    <p>{text}</p>
    <p class="actions">
      <Button className="button" text={say("serve.submit-anyway")} onClick={onSubmit} />
      <Button text={say("serve.no-submit")} onClick={onCancel} />
    </p>
  </div>
);

interface WarningProps {
  readonly text: string;
  readonly onSubmit: () => void;
  readonly onCancel: () => void;
}

/** Attributes of a field whose text a browser should not change, such as a formula or an address. */
export const LITERAL = { spellcheck: false, autocomplete: "off", autocapitalize: "none" } as const;
