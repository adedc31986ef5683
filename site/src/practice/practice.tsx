// The practice page: settings, one problem after the other, and the progress.

import type { JSX } from "preact";
import { useMemo, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import type { Index } from "../bank.js";
import { message, textOf, say, type TextKey } from "../text/text.js";
import {
  ANY_WISH,
  writeWish,
  listDueItems,
  updateProgress,
  findFault,
  parseWish,
  listSetItems,
  listItems,
  type Item,
  nameItem,
  findFirstNew,
  isInIndex,
  chooseNext,
  type Progress,
  type Wish,
} from "./choice.js";
import {
  type TopicClass,
  describeTopicClass,
  countAnswer,
  chooseFromClass,
  listDueClasses,
  describeOutcomes,
  makeClassFinder,
} from "./lesson-credit.js";
import { Current } from "./current.js";
import { useStoredState } from "./stored-state.js";
import { useVisits, visitNumber } from "./visits.js";
import { Settings } from "./settings.js";
import { Sheet, parseSheetWish } from "./sheet.js";
import { WithIndex } from "./with-index.js";

export function Practice(): JSX.Element {
  const { search } = window.location;
  const sheet = parseSheetWish(search);
  return (
    <WithIndex>
      {(index) =>
        sheet ? <Sheet index={index} wish={parseWish(search)} initialSheet={sheet} /> : <Session index={index} />
      }
    </WithIndex>
  );
}

function Session({ index }: { index: Index }) {
  const [wish, setWish] = useState<Wish>(() => parseWish(window.location.search));
  const [stored, changeStored] = useStoredState();
  const { progress, lessons: skills } = stored;
  const { visit, showNext, replace } = useVisits<Visit>(
    "question",
    () => ({ ...chooseQuestion(index, wish, progress, null, ""), isAnswered: false }),
    ({ item }) => item === null || isInIndex(index, item),
    () => {
      setWish(parseWish(window.location.search));
      setReviewClass(null);
      setNotes([]);
      setMoved(true);
    },
  );
  const { place, item, isAnswered } = visit;
  const [hasMoved, setMoved] = useState(false); // whether the page began with a different question
  const [isAnsweringDue, setAnsweringDue] = useState(false); // whether due questions are being answered
  const [reviewClass, setReviewClass] = useState<TopicClass | null>(null); // the class of the current review question
  const [notes, setNotes] = useState<readonly string[]>([]);
  const askedNames = useRef<string[]>([]); // names of questions asked from due classes
  const findClasses = useMemo(() => makeClassFinder(index), [index]);
  const dueItems = listDueItems(index, progress, Date.now());
  const dueClasses = listDueClasses(skills, Date.now(), findClasses);
  const orderedItems = useMemo(() => (wish.set ? listSetItems(index, wish) : null), [index, wish]);

  const show = (chosen: ChosenQuestion, newReviewClass: TopicClass | null = null): void => {
    setNotes([]);
    setReviewClass(newReviewClass);
    setMoved(true);
    showNext({ ...chosen, isAnswered: false });
  };
  const choose = (newWish: Wish, wishedPlace: number | null): void =>
    show(chooseQuestion(index, newWish, progress, wishedPlace, item ? nameItem(item) : ""));
  /** Show the next due question: one answered wrongly, else one of a class to review, else one as wished. */
  const showDue = (isFirst: boolean): void => {
    const [nextDueItem] = dueItems.filter((dueItem) => isFirst || !item || nameItem(dueItem) !== nameItem(item));
    if (nextDueItem) return show({ place, item: nextDueItem });
    const isLast = ({ topic, classIndex }: TopicClass): boolean =>
      topic === reviewClass?.topic && classIndex === reviewClass.classIndex;
    const dueClass = dueClasses.find((candidate) => !isLast(candidate)) ?? dueClasses[0];
    const reviewItem = dueClass && chooseFromClass(dueClass, skills, askedNames.current, Math.random);
    if (reviewItem) {
      askedNames.current.push(nameItem(reviewItem));
      return show({ place, item: reviewItem }, dueClass);
    }
    setAnsweringDue(false);
    choose(wish, place);
  };
  const countVerdict = (item: Item, isRight: boolean, isHelped: boolean): void => {
    const now = Date.now();
    const result = countAnswer(skills, item, { isRight, isHelped, isRepeated: isAnswered, now }, findClasses);
    replace({ ...visit, isAnswered: true });
    setNotes(describeOutcomes(result.outcomes));
    changeStored({ progress: updateProgress(progress, item, isRight, now), lessons: result.skills });
  };
  const fault = useMemo(() => findFault(index, wish, window.location.search), [index, wish]);

  const changeWish = (newWish: Wish) => {
    setWish(newWish);
    choose(newWish, null);
    window.history.replaceState(window.history.state, "", writeWish(newWish) || window.location.pathname);
  };
  return (
    <div class="workspace">
      <div class="choosing">
        <Due
          count={dueItems.length + dueClasses.length}
          isAnswering={isAnsweringDue}
          reviewClass={reviewClass && isAnsweringDue ? describeTopicClass(reviewClass) : null}
          onStart={() => {
            setAnsweringDue(true);
            showDue(true);
          }}
        />
        <Settings index={index} wish={wish} stored={stored} onWish={changeWish} onRestored={changeStored} />
        {orderedItems && orderedItems.length > 0 ? (
          <p class="muted set-place">
            {say("practice.set-place", {
              number: (place % orderedItems.length) + 1,
              count: orderedItems.length,
              set: wish.set,
            })}
          </p>
        ) : null}
      </div>
      {item && !fault ? (
        <Current
          key={`${nameItem(item)} ${visitNumber()}`}
          item={item}
          level={index.feedback}
          hasArrived={hasMoved}
          notes={notes}
          onVerdict={(isRight, isHelped) => countVerdict(item, isRight, isHelped)}
          onNext={() => {
            if (isAnsweringDue) showDue(false);
            else choose(wish, place + 1);
          }}
        />
      ) : (
        <div class="task" role="alert">
          <p>{textOf(fault ?? message("practice.none"))}</p>
          <p class="ways">
            {suggestWishes(index, wish).map(([key, suggestion]) => (
              <Button key={key} className="button" text={say(key)} onClick={() => changeWish(suggestion)} />
            ))}
          </p>
        </div>
      )}
    </div>
  );
}

/** Return wishes to suggest if nothing fits a wish: its arm alone, its question alone, or anything. */
function suggestWishes(index: Index, wish: Wish): [TextKey, Wish][] {
  const suggestions: [TextKey, Wish][] = [
    ["practice.this-arm", { ...ANY_WISH, family: wish.family }],
    ["practice.this-question", { ...ANY_WISH, question: wish.question }],
    ["practice.all", ANY_WISH],
  ];
  return suggestions.filter(
    ([, suggestion], i) =>
      (i === 2 || writeWish(suggestion) !== writeWish(ANY_WISH)) && listItems(index, suggestion).length > 0,
  );
}

/** A question, and its place in a set. */
type ChosenQuestion = { readonly place: number; readonly item: Item | null };
/** A question that is shown, and whether it was answered before. */
type Visit = ChosenQuestion & { readonly isAnswered: boolean };

/** Choose a question: at the wished place of a set, or the set's first new one; without a set, the next one. */
function chooseQuestion(
  index: Index,
  wish: Wish,
  progress: Progress,
  wishedPlace: number | null,
  lastName: string,
): ChosenQuestion {
  if (!wish.set) return { place: 0, item: chooseNext(index, wish, progress, Date.now(), Math.random, lastName) };
  const orderedItems = listSetItems(index, wish);
  const place = wishedPlace ?? findFirstNew(orderedItems, progress);
  return { place, item: orderedItems[place % orderedItems.length] ?? null };
}

/** Typical number of minutes for a question. */
const MINUTES_PER_QUESTION = 1.5;

interface DueProps {
  readonly count: number;
  /** Whether due questions are being answered. */
  readonly isAnswering: boolean;
  /** The lesson and class of the current review question, in words; null for other questions. */
  readonly reviewClass: string | null;
  readonly onStart: () => void;
}

/** The number of questions due for review, and a button that starts with them. */
function Due({ count, isAnswering, reviewClass, onStart }: DueProps): JSX.Element | null {
  if (count === 0 && !isAnswering) return null;
  return (
    <p class="due" role="status">
      {isAnswering ? (
        <span>
          {textOf(count > 0 ? message("practice.due-left", { count }) : message("practice.due-done"))}
          {reviewClass && count > 0 ? <span class="muted"> · {reviewClass}</span> : null}
        </span>
      ) : (
        <>
          <strong>{say("practice.due-now", { count, minutes: Math.ceil(MINUTES_PER_QUESTION * count) })}</strong>
          <Button className="quiet small" text={say("practice.due-start")} onClick={onStart} />
        </>
      )}
    </p>
  );
}
