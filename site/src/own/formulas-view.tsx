// Show the formulas of J and det J, or why there are none.

import type { JSX } from "preact";
import { useMemo } from "preact/hooks";

import { Words } from "../arm/letters.js";
import type { Arm } from "../arm/model.js";
import { memo } from "../pace.js";
import { Tex } from "../practice/math.js";
import { formatNumber, numberSeparator, say } from "../text/text.js";
import { writeMatrix, writeProduct } from "./formula-latex.js";
import { deriveFormulas, MAX_FORMULA_JOINTS, type Product } from "./formulas.js";
import type { Row } from "./table.js";

interface FormulasProps {
  readonly arm: Arm;
  /** The rows of the typed table. */
  readonly rows: readonly Row[];
}

// `memo`: formulas do not change while the arm moves.
export const FormulasView = memo(({ arm, rows }: FormulasProps): JSX.Element => {
  const formulas = useMemo(
    () =>
      deriveFormulas(
        arm,
        rows.map(({ isReversed }) => isReversed),
      ),
    [arm],
  );
  if (typeof formulas === "string")
    return (
      <section class="own-formulas">
        <h3>{say("own.formulas")}</h3>
        <p class="muted">{say(`own.formulas.${formulas}`, { count: MAX_FORMULA_JOINTS })}</p>
      </section>
    );
  const { determinant, jacobian, lengths } = formulas;
  const values = lengths.flatMap(({ latex, value }, i) =>
    value !== null && jacobian.flat().some((entry) => usesLength(entry, i))
      ? [`${latex} = ${toLatex(value)}\\,\\mathrm{m}`]
      : [],
  );
  return (
    <section class="own-formulas">
      <h3>{say("own.formulas")}</h3>
      <p>
        <Tex latex={`J = ${writeMatrix(jacobian, formulas)}`} block />
      </p>
      {determinant === "long" ? (
        <p class="muted">
          <Words text={say("own.formulas.long-det")} />
        </p>
      ) : determinant ? (
        <p>
          <Tex latex={`\\det J = ${writeProduct(determinant, formulas)}`} block />
        </p>
      ) : null}
      {values.length > 0 ? (
        <p>
          {values.map((latex, i) => (
            <span key={latex}>
              {i > 0 && numberSeparator()}
              <Tex latex={latex} />
            </span>
          ))}
        </p>
      ) : null}
    </section>
  );
});

const usesLength = ({ powers, factors }: Product, index: number): boolean =>
  [powers, ...factors.flatMap(({ terms }) => terms.map((term) => term.powers))].some((list) => (list[index] ?? 0) > 0);

const toLatex = (value: number): string => formatNumber(value).replace("−", "-").replace(",", "{,}");
