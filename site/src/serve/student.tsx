// A student's page: the problems of an assignment, one question at a time, judged by the server.

import type { JSX } from "preact";
import { useRef, useState } from "preact/hooks";

import type { AskedPart, AskedProblem } from "../bank.js";
import { Warning } from "../controls.js";
import { Places } from "../course/places.js";
import { Hints, Question } from "../practice/question.js";
import { WithLoaded } from "../practice/with-index.js";
import { listen, useInterval, useRunning } from "../scheduling.js";
import { storage } from "../storage.js";
import { say } from "../text/text.js";
import { get, inLanguage, setPerson, type Work } from "./api.js";
import { NotebookWork } from "./notebook.js";
import { type Connection, hasArrived, Outbox } from "./outbox.js";
import { isTelling, MARKS, ShownResult, writePoints } from "./shown.js";
import { formatDistance, formatTime } from "../text/times.js";

/** A question with its name, such as "p1.jacobian", and its number, such as "1.2". */
export interface NamedQuestion {
  readonly name: string;
  readonly number: string;
  readonly problem: AskedProblem;
  readonly part: AskedPart;
}

/** Return the questions of a student's problems in their order. */
export const listQuestions = ({ problems }: Pick<Work, "problems">): readonly NamedQuestion[] =>
  problems.flatMap(({ slot, problem }, i) =>
    problem.parts.map((part, k) => ({ name: `${slot}.${part.name}`, number: `${i + 1}.${k + 1}`, problem, part })),
  );

export const StudentPage = (): JSX.Element => (
  <WithLoaded load={() => get<Work>(inLanguage("work"))}>{(work) => <Workplace initialWork={work} />}</WithLoaded>
);

const readPart = (): string => new URLSearchParams(window.location.search).get("part") ?? "";

/** How often the time that is left is shown anew, and results are asked for that take long, in milliseconds. */
const CLOCK_STEP = 20_000;
const MARKING_WAIT = 3000;

function Workplace({ initialWork }: { initialWork: Work }): JSX.Element {
  const [work, setWork] = useState(initialWork);
  const [connection, setConnection] = useState<Connection>("saved");
  const [judged, setJudged] = useState<{ readonly part: string; readonly count: number }>({ part: "", count: 0 });
  const [refusal, setRefusal] = useState<Readonly<Record<string, string>>>({});
  const [clockOffset] = useState(() => Date.parse(initialWork.now) - Date.now());
  const [, setTick] = useState(0);
  const questions = listQuestions(work);
  const names = questions.map(({ name }) => name);
  const findPlace = (name: string) => Math.max(0, names.indexOf(name));
  const [{ place, visits }, setVisit] = useState(() => ({ place: findPlace(readPart()), visits: 0 }));
  const reload = () => void get<Work>(inLanguage("work")).then(setWork, () => undefined); // the page shows what it has
  const isMarking = work.submissions.some(({ kind, state }) => kind === "answer" && state === "waiting");
  const [outbox] = useState(
    () =>
      new Outbox({
        storage,
        key: `qdot-serve ${window.location.pathname} ${initialWork.student.id}`,
        onConnection: setConnection,
        onJudged: ({ part, text }, { results, state, ...news }) => {
          if (state === "waiting") reload();
          setWork((old) => ({
            ...old,
            ...news,
            results: { ...old.results, ...results },
            answers: { ...old.answers, [part]: text },
          }));
          setRefusal((old) => ({ ...old, [part]: "" }));
          setJudged(({ count }) => ({ part, count: count + 1 }));
        },
        onRefused: ({ part }, sentence) => setRefusal((old) => ({ ...old, [part]: sentence || say("serve.refused") })),
      }),
  );
  useInterval(reload, MARKING_WAIT, isMarking);
  useInterval(() => setTick((tick) => tick + 1), CLOCK_STEP);
  useRunning(() => {
    setPerson(initialWork.person);
    void outbox.send(); // what an earlier page could not send
    return [
      () => outbox.end(),
      listen(window, "online", () => void outbox.send()),
      listen(window, "pagehide", () => outbox.leave()),
      listen(document, "visibilitychange", () => (document.hidden ? outbox.leave() : reload())),
      listen(window, "storage", (event: StorageEvent) => hasArrived(event) && reload()), // from another tab
      listen(window, "popstate", () => {
        const place = findPlace(readPart());
        setVisit((old) => (old.place === place ? old : { place, visits: old.visits + 1 })); // else a link in the page
      }),
    ];
  }, []);
  const goTo = (newPlace: number) => {
    const address = new URL(window.location.href);
    address.searchParams.set("part", questions[newPlace]!.name);
    window.history.pushState(window.history.state, "", address);
    setVisit({ place: newPlace, visits: visits + 1 });
  };
  const question = questions[place]!;
  const graded = work.submissions.find(({ kind, state }) => kind === "notebook" && state === "marked")?.id;
  const earlierGraded = useRef(graded);
  const hasNewAnswers = earlierGraded.current !== graded;
  earlierGraded.current = graded;
  const now = Date.now() + clockOffset;
  const numberOf = (name: string) => questions.find((other) => other.name === name)?.number ?? "";
  return (
    <div class="workspace">
      <section class="choosing round" aria-label={work.title}>
        <p class="round-head">
          <strong>{work.title}</strong>
          <span class="score">{say("serve.points", { points: writePoints(work.score), max: work.max_score })}</span>
        </p>
        <Places
          places={questions.map(({ name, number }) => ({
            number,
            mark: MARKS[work.results[name]?.outcome ?? "missing"],
          }))}
          place={place}
          onPlace={goTo}
        />
        <p class="muted">
          <DueDate work={work} now={now} /> {work.attempts.rule}
          {work.attempts.left === null ? null : ` ${say("serve.attempts-left", { count: work.attempts.left })}`}{" "}
          {work.notes.join(" ")} {work.closed ? <strong>{work.closed}</strong> : null}{" "}
          <span role="status" class={`connection ${connection}`}>
            {say(connection === "waiting" && storage === null ? "serve.waiting-open" : `serve.${connection}`)}
          </span>
        </p>
        {work.practice ? (
          <p>
            {work.practice.home ? (
              <>
                <strong>{say("serve.practising")}</strong> <a href={work.practice.home}>{say("serve.stop-practice")}</a>
                {" · "}
              </>
            ) : null}
            <a href={work.practice.next}>{say(work.practice.home ? "serve.other-set" : "serve.practise")}</a>
          </p>
        ) : null}
        {work.takes_notebooks ? <NotebookWork work={work} onGraded={reload} /> : null}
      </section>
      <ServedQuestion
        key={`${question.name} ${visits} ${graded}`}
        {...{ question, work, outbox, connection }}
        hasArrived={visits > 0 && !hasNewAnswers}
        isOverdue={work.due !== null && now > Date.parse(work.due)}
        followedFrom={numberOf(work.results[question.name]?.followed_from ?? "")}
        refusal={refusal[question.name] ?? ""}
        judgedCount={judged.part === question.name ? judged.count : 0}
        onType={(text) => {
          outbox.saveDraft(question.name, text);
          setWork((old) => ({ ...old, drafts: { ...old.drafts, [question.name]: text } }));
        }}
        onSubmit={(text) => {
          outbox.submit(question.name, text);
          setTick((tick) => tick + 1);
        }}
        onNext={() => goTo((place + 1) % questions.length)}
      />
    </div>
  );
}

/** The due date in the reader's time zone, and how long it is until then. */
function DueDate({ work: { due, is_late, late_rule }, now }: { work: Work; now: number }): JSX.Element | null {
  if (due === null) return null;
  const left = Date.parse(due) - now;
  return (
    <span class="due-date">
      {say("serve.due", { time: formatTime(due), distance: formatDistance(left) })}
      {is_late ? <strong> {say("serve.late")}</strong> : null}
      {left < 0 || is_late ? ` ${late_rule}` : null}
    </span>
  );
}

interface ServedQuestionProps {
  readonly question: NamedQuestion;
  readonly work: Work;
  readonly outbox: Outbox;
  readonly connection: Connection;
  readonly hasArrived: boolean;
  /** Whether the due date has passed. */
  readonly isOverdue: boolean;
  /** The number of the question from whose answer this one follows, or "". */
  readonly followedFrom: string;
  /** Why the server did not take the last answer. */
  readonly refusal: string;
  /** Changes with each verdict on this question since the page was opened. */
  readonly judgedCount: number;
  readonly onType: (text: string) => void;
  readonly onSubmit: (text: string) => void;
  readonly onNext: () => void;
}

/** A question that the server judges. */
function ServedQuestion(props: ServedQuestionProps): JSX.Element {
  const { work, outbox, connection, judgedCount } = props;
  const { problem, part, name } = props.question;
  const { [name]: shown } = work.results;
  const pending = outbox.pendingOf(name);
  const submittedText = pending?.text ?? work.answers[name];
  const [storedText] = useState(outbox.draftOf(name) ?? work.drafts[name] ?? submittedText ?? "");
  const [answer, setAnswer] = useState(storedText);
  const [fieldsText, setFieldsText] = useState(storedText); // the stored text, as the fields write it
  const latestText = useRef(storedText === "" ? "" : null);
  const [error, setError] = useState("");
  const [isAsking, setAsking] = useState(false); // whether to submit in spite of warnings
  const [repeats, setRepeats] = useState({ count: 0, isLatest: false });
  const [pose, setPose] = useState<Readonly<Record<string, number>> | undefined>(undefined);
  const isRight = shown?.outcome === "correct";
  const closed = work.closed || (shown?.tries_left === 0 && !isRight ? say("serve.no-tries") : "");
  const [isPending, isClosed] = [pending !== undefined, closed !== ""];
  const hasWork = Object.values(work.results).some(({ outcome }) => outcome !== "missing");
  const makesLate = props.isOverdue && !work.is_late && work.attempts.left === null && hasWork; // else attempts are apart
  const isSame = answer === (submittedText === storedText ? fieldsText : submittedText);
  const hasBlank = work.attempts.tries !== null && part.key.type !== "text" && /\bblank\b/.test(answer);
  const submit = () => {
    setAsking(false);
    setRepeats({ ...repeats, isLatest: false });
    props.onSubmit(answer);
  };
  const check = () => {
    const reason = closed || (answer.trim() ? "" : say("serve.empty"));
    setError(reason);
    if (reason || isPending) return;
    if (isSame && shown && shown.outcome !== "ungraded") setRepeats({ count: repeats.count + 1, isLatest: true });
    else if ((makesLate || hasBlank) && !isAsking) setAsking(true);
    else submit();
  };
  return (
    <Question
      name={name}
      {...{ problem, part, answer, storedText, isClosed }}
      hasArrived={props.hasArrived}
      isOpen={!isRight && !isClosed}
      isDone={isRight || isClosed}
      checkText={say(isPending ? "serve.submitting" : "serve.submit")}
      nextText={say("serve.next")}
      onAnswer={(text) => {
        setAnswer(text);
        if (latestText.current === null) setFieldsText(text);
        else if (text !== latestText.current) props.onType(text);
        latestText.current = text;
      }}
      onCheck={check}
      onNext={props.onNext}
      error={error || props.refusal}
      notice={
        isAsking ? (
          <Warning
            text={`${hasBlank ? say("serve.has-blank") : ""} ${makesLate ? `${say("serve.makes-late")} ${work.late_rule}` : ""}`}
            onSubmit={submit}
            onCancel={() => setAsking(false)}
          />
        ) : isPending && (connection === "waiting" || connection === "signed-out") ? (
          <p role="alert">{say("serve.will-submit")}</p>
        ) : null
      }
      verdict={
        shown && isTelling(shown) ? (
          <>
            {repeats.isLatest && isSame ? <p class="muted">{say("serve.same-answer")}</p> : null}
            <ShownResult
              shown={shown}
              followedFrom={props.followedFrom}
              hasPose={pose !== undefined}
              hasAnswer={!isSame}
            />
          </>
        ) : null
      }
      verdictNumber={judgedCount + repeats.count}
      onVerdictShown={() => setPose(shown?.pose ?? undefined)}
      pose={pose}
    >
      {work.attempts.tries !== null && !isRight ? (
        <p class="muted">{say("serve.tries-left", { count: shown?.tries_left ?? 0, all: work.attempts.tries })}</p>
      ) : null}
      {part.hints.length > 0 ? (
        <section class="help-steps">
          <Hints part={part} lang={problem.lang} />
        </section>
      ) : null}
    </Question>
  );
}
