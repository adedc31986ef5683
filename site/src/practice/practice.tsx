// The practice page: what to practise, one problem after the other, and how it went.

import type { JSX } from "preact";
import { useEffect, useMemo, useState } from "preact/hooks";

import type { Index } from "../bank.js";
import { loadIndex } from "../load.js";
import { message, said } from "../text/text.js";
import {
  ANYTHING,
  asLink,
  dueItems,
  attempted,
  faultOf,
  fromLink,
  inOrder,
  type Item,
  nameOf,
  placeIn,
  next,
  type Progress,
  type Wish,
} from "./choice.js";
import { Due } from "./due.js";
import { keep, kept } from "./progress.js";
import { Current, Failed } from "./current.js";
import { Settings } from "./settings.js";
import { Sheet, sheetFrom } from "./sheet.js";
import { storage } from "./storage.js";
import { isToday, TodayDoor, TodaysArm } from "./todays-arm.js";

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
  if (index && isToday(window.location.search)) return <TodaysArm index={index} />;
  return index ? (
    <Session index={index} />
  ) : (
    <p role="status" class="loading">
      {said(message("practice.loading"))}
    </p>
  );
}

function Session({ index }: { index: Index }) {
  const [wish, setWish] = useState<Wish>(() => fromLink(window.location.search));
  const [progress, setProgress] = useState<Progress>(() => kept(storage));
  const [{ place, item }, setChosen] = useState(() => chosenBy(index, wish, progress, null, ""));
  const [moved, setMoved] = useState(false);
  const [queued, setQueued] = useState(false); // whether what is due is being answered
  const due = dueItems(index, progress, Date.now());
  const order = useMemo(() => (wish.set ? inOrder(index, wish) : null), [index, wish]);

  const choose = (wanted: Wish, from: number | null): void =>
    setChosen(chosenBy(index, wanted, progress, from, item ? nameOf(item) : ""));
  const setItem = (next: Item): void => setChosen({ place, item: next });
  /** The first of what is due, or the next one; when there is none left, as it was wished. */
  const fromQueue = (isFirst: boolean): void => {
    const [first] = due.filter((each) => isFirst || !item || nameOf(each) !== nameOf(item));
    if (first) setItem(first);
    else {
      setQueued(false);
      choose(wish, place);
    }
  };
  const fault = useMemo(() => faultOf(index, wish, window.location.search), [index, wish]);

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
        <Due
          count={due.length}
          going={queued}
          onStart={() => {
            setQueued(true);
            fromQueue(true);
          }}
        />
        {wish.set ? null : <TodayDoor index={index} />}
        <Settings index={index} wish={wish} progress={progress} onWish={wished} onProgress={noted} />
        {order && order.length > 0 ? (
          <p class="muted set-place">
            {said(
              message("practice.set-place", {
                number: (place % order.length) + 1,
                count: order.length,
                set: wish.set,
              }),
            )}
          </p>
        ) : null}
      </div>
      {item && !fault ? (
        <Current
          key={nameOf(item)}
          item={item}
          level={index.feedback}
          arrived={moved}
          onVerdict={(right) => noted(attempted(progress, item, right, Date.now()))}
          onNext={() => {
            setMoved(true);
            if (queued) fromQueue(false);
            else choose(wish, place + 1);
          }}
        />
      ) : (
        <div class="task" role="alert">
          <p>{said(fault ?? message("practice.none"))}</p>
          <button type="button" class="button" onClick={() => wished(ANYTHING)}>
            {said(message("practice.all"))}
          </button>
        </div>
      )}
    </div>
  );
}

/** What is asked, and its place in a set: the one `from` which one goes on, else the first that was not tried yet. */
function chosenBy(
  index: Index,
  wish: Wish,
  progress: Progress,
  from: number | null,
  last: string,
): { place: number; item: Item | null } {
  if (!wish.set) return { place: 0, item: next(index, wish, progress, Date.now(), Math.random, last) };
  const order = inOrder(index, wish);
  const place = from ?? placeIn(order, progress);
  return { place, item: order[place % order.length] ?? null };
}
