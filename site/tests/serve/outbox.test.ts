// @vitest-environment happy-dom
// What a student typed and submitted: sent once, in spite of double clicks, tabs, reloads and lost connections.
import { afterEach, beforeEach, expect, test, vi } from "vitest";

import { type Connection, hasArrived, Outbox } from "../../src/serve/outbox.js";
import { type Answer, makeStorage, type Sent, serve } from "./server.js";

const JUDGED = { results: {}, score: 1, is_late: false, attempts: { left: null, rule: "" }, state: "marked" };
const accept = ({ path }: Sent): Answer => [200, path === "answers" ? JUDGED : {}];

function makeOutbox(storage: Storage | null = makeStorage()) {
  const seen = { connections: [] as Connection[], judged: [] as string[], refused: [] as string[] };
  const outbox = new Outbox({
    storage,
    key: "key",
    onConnection: (connection) => seen.connections.push(connection),
    onJudged: ({ part, text }) => seen.judged.push(`${part} ${text}`),
    onRefused: (_, sentence) => seen.refused.push(sentence),
  });
  return { outbox, ...seen };
}
const pass = (milliseconds: number) => vi.advanceTimersByTimeAsync(milliseconds);
const answersOf = (requests: Sent[]) => requests.filter(({ path }) => path === "answers").map(({ body }) => body);

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test("two presses, and a press in another tab, submit an answer once", async () => {
  const requests = serve(accept);
  const storage = makeStorage();
  const { outbox, judged } = makeOutbox(storage);
  outbox.submit("p1.a", "1");
  outbox.submit("p1.a", "1");
  makeOutbox(storage).outbox.submit("p1.a", "1");
  await pass(0);
  expect(new Set(answersOf(requests).map(({ request }) => request)).size).toBe(1);
  expect(judged).toEqual(["p1.a 1"]);
  expect(outbox.pendingOf("p1.a")).toBeUndefined();
});

const CONNECTIONS: Readonly<Record<number, Connection>> = { 401: "signed-out", 429: "busy" };

test.each([null, [503, {}], [401, { error: "Sign in." }], [429, { error: "Too often." }]] as Answer[])(
  "an answer that meets %j is kept, also over a reload, and submitted with the same number",
  async (failure) => {
    const storage = makeStorage();
    const first = serve(() => failure);
    const { outbox, connections } = makeOutbox(storage);
    outbox.submit("p1.a", "1");
    await pass(0);
    expect(connections.at(-1)).toBe(CONNECTIONS[failure?.[0] ?? 0] ?? "waiting");
    outbox.end();
    const second = serve(accept);
    const { outbox: reloaded, judged } = makeOutbox(storage);
    expect(reloaded.pendingOf("p1.a")?.text).toBe("1");
    await reloaded.send();
    expect(judged).toEqual(["p1.a 1"]);
    expect(answersOf(second)[0]!.request).toBe(answersOf(first)[0]!.request);
  },
);

test("the browser tries again by itself until the connection is back", async () => {
  let isOnline = false;
  const requests = serve((sent) => (isOnline ? accept(sent) : null));
  const { outbox, judged, connections } = makeOutbox();
  outbox.submit("p1.a", "1");
  await pass(20_000);
  expect(judged).toEqual([]);
  isOnline = true;
  await pass(30_000);
  expect(judged).toEqual(["p1.a 1"]);
  expect(connections.at(-1)).toBe("saved");
  expect(new Set(answersOf(requests).map(({ request }) => request)).size).toBe(1);
});

test("an answer that the server refuses is not sent again, and what comes after it is", async () => {
  const requests = serve(({ body, path }) =>
    path === "answers" && body.part === "p1.a" ? [409, { error: "It is too late." }] : [200, JUDGED],
  );
  const { outbox, judged, refused } = makeOutbox();
  outbox.submit("p1.a", "1");
  outbox.submit("p1.b", "2");
  await pass(0);
  expect(refused).toEqual(["It is too late."]);
  expect(judged).toEqual(["p1.b 2"]);
  await pass(60_000);
  expect(answersOf(requests).length).toBe(2);
});

test("a changed answer replaces the one that has not arrived, with a number of its own", async () => {
  let isOnline = false;
  const requests = serve((sent) => (isOnline ? accept(sent) : null));
  const { outbox, judged } = makeOutbox();
  outbox.submit("p1.a", "1");
  await pass(0);
  outbox.submit("p1.a", "2");
  isOnline = true;
  await pass(60_000);
  expect(judged).toEqual(["p1.a 2"]);
  expect(new Set(answersOf(requests).map(({ request }) => request)).size).toBe(2);
});

test.each([true, false])("a text that is typed is saved a second later (browser stores: %s)", async (hasStorage) => {
  const requests = serve(accept);
  const { outbox, connections } = makeOutbox(hasStorage ? makeStorage() : null);
  for (const text of ["s", "si", "sin"]) {
    outbox.saveDraft("p1.a", text);
    await pass(300);
  }
  await pass(1000);
  expect(requests.map(({ body }) => body)).toEqual([{ part: "p1.a", text: "sin" }]);
  expect(connections.at(-1)).toBe("saved");
  expect(outbox.draftOf("p1.a")).toBeUndefined(); // the server has it
});

test("a text that is typed without a connection is there after a reload, and reaches the server later", async () => {
  const storage = makeStorage();
  serve(() => null);
  const { outbox } = makeOutbox(storage);
  outbox.saveDraft("p1.a", "sin");
  await pass(5000);
  outbox.end();
  const requests = serve(accept);
  const { outbox: reloaded } = makeOutbox(storage);
  expect(reloaded.draftOf("p1.a")).toBe("sin");
  await reloaded.send();
  expect(requests.map(({ body }) => body)).toEqual([{ part: "p1.a", text: "sin" }]);
});

test("what is typed while a text is on its way is not lost", async () => {
  const { outbox } = makeOutbox();
  const requests = serve(({ body }) => {
    if (body.text === "s") outbox.saveDraft("p1.a", "si");
    return [200, {}];
  });
  outbox.saveDraft("p1.a", "s");
  await pass(5000);
  expect(requests.map(({ body }) => body.text)).toEqual(["s", "si"]);
});

test("another tab is told of an answer that has arrived, but not of every key that is pressed", () => {
  const entry = (drafts: object, ...requests: string[]) =>
    JSON.stringify({ drafts, pending: requests.map((request) => ({ request, part: "p1.a", text: '"request"' })) });
  const change = (oldValue: string | null, newValue: string | null) => hasArrived({ oldValue, newValue });
  expect(change(entry({}, "1"), entry({}))).toBe(true);
  expect(change(entry({}), entry({ a: "s" }))).toBe(false);
  expect(change(null, entry({}, "1"))).toBe(false);
  expect(change(entry({}), null)).toBe(false);
  expect(change("no JSON", "{")).toBe(false);
});
