// The practice page: what to practise, one problem after the other, and how it went.

import type { JSX } from "preact";
import { useMemo, useRef, useState } from "preact/hooks";

import { Button } from "../button.js";
import type { Index } from "../bank.js";
import { message, said, say, type TextKey } from "../text/text.js";
import {
  ANYTHING,
  asLink,
  dueItems,
  attempted,
  faultOf,
  fromLink,
  inOrder,
  items,
  type Item,
  nameOf,
  placeIn,
  next,
  type Progress,
  type Wish,
} from "./choice.js";
import {
  type ClassOfTopic,
  classInWords,
  counted,
  drawnFrom,
  dueClasses,
  outcomesInWords,
  sortingOf,
} from "./counting.js";
import { keep, kept } from "./progress.js";
import { Current } from "./current.js";
import { type AllKept, keepAll } from "./all-kept.js";
import { Settings } from "./settings.js";
import { Sheet, sheetFrom } from "./sheet.js";
import { keepSkills, keptSkills, type Skills } from "./skills.js";
import { storage } from "../storage.js";
import { keptDay } from "./today.js";
import { isToday, TodayDoor, TodaysArm } from "./todays-arm.js";
import { WithIndex } from "./with-index.js";

export function Practice(): JSX.Element {
  const { search } = window.location;
  const sheet = sheetFrom(search);
  return (
    <WithIndex>
      {(index) => {
        if (sheet) return <Sheet index={index} wish={fromLink(search)} first={sheet} />;
        return isToday(search) ? <TodaysArm index={index} /> : <Session index={index} />;
      }}
    </WithIndex>
  );
}

function Session({ index }: { index: Index }) {
  const [wish, setWish] = useState<Wish>(() => fromLink(window.location.search));
  const [progress, setProgress] = useState<Progress>(() => kept(storage));
  const [{ place, item }, setChosen] = useState(() => chosenBy(index, wish, progress, null, ""));
  const [skills, setSkills] = useState<Skills>(() => keptSkills(storage));
  const [moves, setMoves] = useState(0);
  const [restores, setRestores] = useState(0);
  const [queued, setQueued] = useState(false); // whether what is due is being answered
  const [aim, setAim] = useState<ClassOfTopic | null>(null); // the class of which the queue asks now
  const [notes, setNotes] = useState<readonly string[]>([]);
  const again = useRef(false); // whether this question was answered before
  const asked = useRef<string[]>([]); // of the classes that are due
  const sorting = useMemo(() => sortingOf(index), [index]);
  const due = dueItems(index, progress, Date.now());
  const dueAgain = dueClasses(skills, Date.now(), sorting);
  const order = useMemo(() => (wish.set ? inOrder(index, wish) : null), [index, wish]);

  const show = (chosen: Chosen, of: ClassOfTopic | null = null): void => {
    again.current = false;
    setNotes([]);
    setAim(of);
    setChosen(chosen);
  };
  const choose = (wanted: Wish, from: number | null): void =>
    show(chosenBy(index, wanted, progress, from, item ? nameOf(item) : ""));
  /** What is due next: what went wrong, then a class to review; when there is none left, what was wished. */
  const fromQueue = (isFirst: boolean): void => {
    const [first] = due.filter((each) => isFirst || !item || nameOf(each) !== nameOf(item));
    if (first) return show({ place, item: first });
    const isLast = ({ topic, at }: ClassOfTopic): boolean => topic === aim?.topic && at === aim.at;
    const of = dueAgain.find((each) => !isLast(each)) ?? dueAgain[0];
    const drawn = of && drawnFrom(of, skills, asked.current, Math.random);
    if (drawn) {
      asked.current.push(nameOf(drawn));
      return show({ place, item: drawn }, of);
    }
    setQueued(false);
    choose(wish, place);
  };
  const answered = (item: Item, right: boolean, helped: boolean): void => {
    const now = Date.now();
    noted(attempted(progress, item, right, now));
    const found = counted(skills, item, { right, helped, again: again.current, now }, sorting);
    again.current = true;
    setNotes(outcomesInWords(found.outcomes));
    setSkills(found.skills);
    keepSkills(storage, found.skills);
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
  const restored = (all: AllKept) => {
    setProgress(all.progress);
    setSkills(all.lessons);
    keepAll(storage, all);
    setRestores(restores + 1);
  };
  return (
    <div class="workspace">
      <div class="choosing">
        <Due
          count={due.length + dueAgain.length}
          going={queued}
          of={aim && queued ? classInWords(aim) : null}
          onStart={() => {
            setQueued(true);
            fromQueue(true);
          }}
        />
        {wish.set ? null : <TodayDoor key={restores} index={index} />}
        <Settings
          index={index}
          wish={wish}
          kept={{ progress, lessons: skills, today: keptDay(storage) }}
          onWish={wished}
          onKept={restored}
        />
        {order && order.length > 0 ? (
          <p class="muted set-place">
            {say("practice.set-place", { number: (place % order.length) + 1, count: order.length, set: wish.set })}
          </p>
        ) : null}
      </div>
      {item && !fault ? (
        <Current
          key={`${nameOf(item)} ${moves}`}
          item={item}
          level={index.feedback}
          arrived={moves > 0}
          notes={notes}
          onVerdict={(right, helped) => answered(item, right, helped)}
          onNext={() => {
            setMoves(moves + 1);
            if (queued) fromQueue(false);
            else choose(wish, place + 1);
          }}
        />
      ) : (
        <div class="task" role="alert">
          <p>{said(fault ?? message("practice.none"))}</p>
          <p class="ways">
            {waysOn(index, wish).map(([key, to]) => (
              <Button key={key} style="button" text={say(key)} onClick={() => wished(to)} />
            ))}
          </p>
        </div>
      )}
    </div>
  );
}

/** Where one may go on from a wish that nothing fits: what is known of it by itself, or anything. */
function waysOn(index: Index, wish: Wish): [TextKey, Wish][] {
  const ways: [TextKey, Wish][] = [
    ["practice.this-arm", { ...ANYTHING, family: wish.family }],
    ["practice.this-question", { ...ANYTHING, question: wish.question }],
    ["practice.all", ANYTHING],
  ];
  return ways.filter(([, to], i) => (i === 2 || asLink(to) !== asLink(ANYTHING)) && items(index, to).length > 0);
}

type Chosen = { readonly place: number; readonly item: Item | null };

/** What is asked, and its place in a set: the one `from` which one goes on, else the first that was not tried yet. */
function chosenBy(index: Index, wish: Wish, progress: Progress, from: number | null, last: string): Chosen {
  if (!wish.set) return { place: 0, item: next(index, wish, progress, Date.now(), Math.random, last) };
  const order = inOrder(index, wish);
  const place = from ?? placeIn(order, progress);
  return { place, item: order[place % order.length] ?? null };
}

/** Minutes that a question takes, as a rule. */
const EACH = 1.5;

interface DueProps {
  readonly count: number;
  /** Whether what is due is being answered. */
  readonly going: boolean;
  /** The lesson, and the class of its arms, of which is asked now, in words; null for what went wrong. */
  readonly of: string | null;
  readonly onStart: () => void;
}

/** What is due for review, and a button to start with it. */
function Due({ count, going, of, onStart }: DueProps): JSX.Element | null {
  if (count === 0 && !going) return null;
  return (
    <p class="due" role="status">
      {going ? (
        <span>
          {said(count > 0 ? message("practice.due-left", { count }) : message("practice.due-done"))}
          {of && count > 0 ? <span class="muted"> · {of}</span> : null}
        </span>
      ) : (
        <>
          <strong>{say("practice.due-now", { count, minutes: Math.ceil(EACH * count) })}</strong>
          <Button style="quiet small" text={say("practice.due-start")} onClick={onStart} />
        </>
      )}
    </p>
  );
}
