// The practice page: settings, one problem after the other, and the progress.

import type { JSX } from "preact";
import { useMemo, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import type { Index } from "../bank.js";
import { message, textOf, say, type TextKey } from "../text/text.js";
import {
  ANYTHING,
  wishToLink,
  dueItems,
  progressAfter,
  faultOf,
  wishFromLink,
  itemsOfSet,
  itemsFor,
  type Item,
  nameOf,
  placeIn,
  chooseNext,
  type Progress,
  type Wish,
} from "./choice.js";
import {
  type TopicClass,
  classInWords,
  countAnswer,
  chooseFrom,
  dueClasses,
  outcomesInWords,
  classFinderOf,
} from "./lesson-credit.js";
import { Current } from "./current.js";
import { useStoredState } from "./stored-state.js";
import { Settings } from "./settings.js";
import { Sheet, sheetFrom } from "./sheet.js";
import { WithIndex } from "./with-index.js";

export function Practice(): JSX.Element {
  const { search } = window.location;
  const sheet = sheetFrom(search);
  return (
    <WithIndex>
      {(index) =>
        sheet ? <Sheet index={index} wish={wishFromLink(search)} first={sheet} /> : <Session index={index} />
      }
    </WithIndex>
  );
}

function Session({ index }: { index: Index }) {
  const [wish, setWish] = useState<Wish>(() => wishFromLink(window.location.search));
  const [stored, changeStored] = useStoredState();
  const { progress, lessons: skills } = stored;
  const [{ place, item }, setChosen] = useState(() => chosenBy(index, wish, progress, null, ""));
  const [moves, setMoves] = useState(0);
  const [isAnsweringDue, setAnsweringDue] = useState(false); // whether due questions are being answered
  const [aim, setAim] = useState<TopicClass | null>(null); // the class of the current review question
  const [notes, setNotes] = useState<readonly string[]>([]);
  const again = useRef(false); // whether this question was answered before
  const asked = useRef<string[]>([]); // names of questions asked from due classes
  const findClasses = useMemo(() => classFinderOf(index), [index]);
  const due = dueItems(index, progress, Date.now());
  const dueForReview = dueClasses(skills, Date.now(), findClasses);
  const order = useMemo(() => (wish.set ? itemsOfSet(index, wish) : null), [index, wish]);

  const show = (chosen: Chosen, of: TopicClass | null = null): void => {
    again.current = false;
    setNotes([]);
    setAim(of);
    setChosen(chosen);
  };
  const choose = (wanted: Wish, from: number | null): void =>
    show(chosenBy(index, wanted, progress, from, item ? nameOf(item) : ""));
  /** Show the next due question: one answered wrongly, else one of a class to review, else one as wished. */
  const showDue = (isFirst: boolean): void => {
    const [first] = due.filter((dueItem) => isFirst || !item || nameOf(dueItem) !== nameOf(item));
    if (first) return show({ place, item: first });
    const isLast = ({ topic, at }: TopicClass): boolean => topic === aim?.topic && at === aim.at;
    const of = dueForReview.find((dueClass) => !isLast(dueClass)) ?? dueForReview[0];
    const review = of && chooseFrom(of, skills, asked.current, Math.random);
    if (review) {
      asked.current.push(nameOf(review));
      return show({ place, item: review }, of);
    }
    setAnsweringDue(false);
    choose(wish, place);
  };
  const countVerdict = (item: Item, right: boolean, helped: boolean): void => {
    const now = Date.now();
    const result = countAnswer(skills, item, { right, helped, again: again.current, now }, findClasses);
    again.current = true;
    setNotes(outcomesInWords(result.outcomes));
    changeStored({ progress: progressAfter(progress, item, right, now), lessons: result.skills });
  };
  const fault = useMemo(() => faultOf(index, wish, window.location.search), [index, wish]);

  const changeWish = (wanted: Wish) => {
    setWish(wanted);
    window.history.replaceState(null, "", wishToLink(wanted) || window.location.pathname);
    choose(wanted, null);
  };
  return (
    <div class="workspace">
      <div class="choosing">
        <Due
          count={due.length + dueForReview.length}
          isAnswering={isAnsweringDue}
          of={aim && isAnsweringDue ? classInWords(aim) : null}
          onStart={() => {
            setAnsweringDue(true);
            showDue(true);
          }}
        />
        <Settings index={index} wish={wish} stored={stored} onWish={changeWish} onRestored={changeStored} />
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
          hasArrived={moves > 0}
          notes={notes}
          onVerdict={(right, helped) => countVerdict(item, right, helped)}
          onNext={() => {
            setMoves(moves + 1);
            if (isAnsweringDue) showDue(false);
            else choose(wish, place + 1);
          }}
        />
      ) : (
        <div class="task" role="alert">
          <p>{textOf(fault ?? message("practice.none"))}</p>
          <p class="ways">
            {suggestionsFor(index, wish).map(([key, to]) => (
              <Button key={key} style="button" text={say(key)} onClick={() => changeWish(to)} />
            ))}
          </p>
        </div>
      )}
    </div>
  );
}

/** Return wishes to suggest if nothing fits a wish: its arm alone, its question alone, or anything. */
function suggestionsFor(index: Index, wish: Wish): [TextKey, Wish][] {
  const ways: [TextKey, Wish][] = [
    ["practice.this-arm", { ...ANYTHING, family: wish.family }],
    ["practice.this-question", { ...ANYTHING, question: wish.question }],
    ["practice.all", ANYTHING],
  ];
  return ways.filter(
    ([, to], i) => (i === 2 || wishToLink(to) !== wishToLink(ANYTHING)) && itemsFor(index, to).length > 0,
  );
}

/** A question, and its place in a set. */
type Chosen = { readonly place: number; readonly item: Item | null };

/** Choose a question: at the place `from` of a set, else the set's first new one; without a set, the next one. */
function chosenBy(index: Index, wish: Wish, progress: Progress, from: number | null, last: string): Chosen {
  if (!wish.set) return { place: 0, item: chooseNext(index, wish, progress, Date.now(), Math.random, last) };
  const order = itemsOfSet(index, wish);
  const place = from ?? placeIn(order, progress);
  return { place, item: order[place % order.length] ?? null };
}

/** Typical number of minutes for a question. */
const MINUTES_EACH = 1.5;

interface DueProps {
  readonly count: number;
  /** Whether due questions are being answered. */
  readonly isAnswering: boolean;
  /** The lesson and class of the current review question, in words; null for other questions. */
  readonly of: string | null;
  readonly onStart: () => void;
}

/** The number of questions due for review, and a button that starts with them. */
function Due({ count, isAnswering, of, onStart }: DueProps): JSX.Element | null {
  if (count === 0 && !isAnswering) return null;
  return (
    <p class="due" role="status">
      {isAnswering ? (
        <span>
          {textOf(count > 0 ? message("practice.due-left", { count }) : message("practice.due-done"))}
          {of && count > 0 ? <span class="muted"> · {of}</span> : null}
        </span>
      ) : (
        <>
          <strong>{say("practice.due-now", { count, minutes: Math.ceil(MINUTES_EACH * count) })}</strong>
          <Button style="quiet small" text={say("practice.due-start")} onClick={onStart} />
        </>
      )}
    </p>
  );
}
