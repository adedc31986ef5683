// The practice page: what to practise, one problem after the other, and how it went.

import type { JSX } from "preact";
import { useEffect, useMemo, useState } from "preact/hooks";

import type { Index, Problem } from "../bank.js";
import type { Level } from "../grade/levels.js";
import { loadIndex, loadProblem } from "../load.js";
import { message, said } from "../text/text.js";
import {
  asLink,
  attempted,
  fromLink,
  inOrder,
  type Item,
  nameOf,
  placeIn,
  next,
  type Progress,
  type Wish,
} from "./choice.js";
import { keep, kept } from "./progress.js";
import { Settings } from "./settings.js";
import { Sheet, sheetFrom } from "./sheet.js";
import { Task } from "./task.js";

const storage = (() => {
  try {
    return window.localStorage;
  } catch {
    return null; // a browser that keeps nothing
  }
})();

export function Practice(): JSX.Element {
  const [index, setIndex] = useState<Index | null>(null);
  const [failed, setFailed] = useState("");
  const load = () => {
    setFailed("");
    loadIndex().then(setIndex, (error: unknown) => setFailed(String(error)));
  };
  useEffect(load, []);
  if (failed) return <Failed why={failed} onAgain={load} />;
  const sheet = sheetFrom(window.location.search);
  if (index && sheet) return <Sheet index={index} wish={fromLink(window.location.search)} first={sheet} />;
  return index ? <Session index={index} /> : <p role="status">{said(message("practice.loading"))}</p>;
}

function Failed({ why, onAgain }: { why: string; onAgain: () => void }) {
  return (
    <div role="alert">
      <p>{said(message("practice.failed", { why }))}</p>
      <button type="button" class="button" onClick={onAgain}>
        {said(message("practice.again"))}
      </button>
    </div>
  );
}

function Session({ index }: { index: Index }) {
  const [wish, setWish] = useState<Wish>(() => fromLink(window.location.search));
  const [progress, setProgress] = useState<Progress>(() => kept(storage));
  const [place, setPlace] = useState(0);
  const [item, setItem] = useState<Item | null>(null);
  const [moved, setMoved] = useState(false);
  const order = useMemo(() => (wish.set ? inOrder(index, wish) : null), [index, wish]);

  const choose = (wanted: Wish, from: number | null) => {
    const ordered = wanted.set ? inOrder(index, wanted) : null;
    const at = from ?? (ordered ? placeIn(ordered, progress) : 0);
    const last = item ? nameOf(item) : "";
    setPlace(at);
    setItem(
      ordered
        ? (ordered[at % ordered.length] ?? null)
        : next(index, wanted, progress, Date.now(), Math.random, last),
    );
  };
  useEffect(() => choose(wish, null), []);

  const wished = (wanted: Wish) => {
    setWish(wanted);
    window.history.replaceState(null, "", asLink(wanted) || window.location.pathname);
    choose(wanted, null);
  };
  const noted = (now: Progress) => {
    setProgress(now);
    keep(storage, now);
  };
  return (
    <div class="workspace">
      <div class="choosing">
        <Settings index={index} wish={wish} progress={progress} onWish={wished} onProgress={noted} />
        {order && order.length > 0 ? (
          <p class="muted set-place">
            {said(message("practice.set-place", { number: (place % order.length) + 1, count: order.length }))}
          </p>
        ) : null}
      </div>
      {item ? (
        <Current
          key={nameOf(item)}
          item={item}
          level={index.feedback}
          arrived={moved}
          onRight={(right) => noted(attempted(progress, item, right, Date.now()))}
          onNext={() => {
            setMoved(true);
            choose(wish, place + 1);
          }}
        />
      ) : (
        <p class="task">{said(message("practice.none"))}</p>
      )}
    </div>
  );
}

/** One problem; `arrived` at from the one before, it is gone to at once, for keyboards and screen readers, too. */
function Current({
  item,
  level,
  arrived,
  onRight,
  onNext,
}: {
  item: Item;
  level: Level;
  arrived: boolean;
  onRight: (right: boolean) => void;
  onNext: () => void;
}) {
  const [problem, setProblem] = useState<Problem | null>(null);
  const [failed, setFailed] = useState("");
  const load = () => {
    setFailed("");
    loadProblem(item.family, item.key).then(setProblem, (error: unknown) => setFailed(String(error)));
  };
  useEffect(load, [item]);
  if (failed)
    return (
      <div class="task">
        <Failed why={failed} onAgain={load} />
      </div>
    );
  const part = problem?.parts.find(({ kind }) => kind === item.question);
  if (!problem || !part)
    return (
      <p role="status" class="task">
        {said(message("practice.loading"))}
      </p>
    );
  return (
    <>
      <Task
        item={item}
        problem={problem}
        part={part}
        level={level}
        arrived={arrived}
        onVerdict={(verdict) => onRight(verdict.outcome === "correct")}
        onNext={onNext}
      />
    </>
  );
}
