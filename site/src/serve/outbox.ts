// What a student typed and submitted, kept in the browser until the server has it.

import { loadJson, resultOrNull, storeText } from "../storage.js";
import { type Judged, makeRequestId, Refused, request } from "./api.js";

/** A press of Submit: it keeps its number until the server has acknowledged it. */
export type Pending = { readonly request: string; readonly part: string; readonly text: string };

/** What was typed but is not stored on the server yet, by the names of parts; and answers on their way. */
type Stored = { readonly drafts: Readonly<Record<string, string>>; readonly pending: readonly Pending[] };

function parseStored(content: unknown): Stored {
  const { drafts = {}, pending = [] } = (content ?? {}) as Partial<Stored>;
  return { drafts, pending: Array.isArray(pending) ? pending : [] };
}

/** Return whether the change of an entry in the browser's storage says that an answer has reached the server. */
export function hasArrived({ oldValue, newValue }: Pick<StorageEvent, "oldValue" | "newValue">): boolean {
  const [before, after] = [oldValue, newValue].map((text) =>
    resultOrNull(() => parseStored(JSON.parse(text ?? "null"))),
  );
  return (before?.pending.length ?? 0) > (after?.pending.length ?? 0);
}

/** "saved": the server has everything; "waiting", "busy": the browser tries again; "signed-out": a person signs in. */
export type Connection = "saved" | "saving" | "waiting" | "busy" | "signed-out";

export interface OutboxOptions {
  /** The browser's storage, null if it stores nothing; and the name of the entry in it. */
  readonly storage: Storage | null;
  readonly key: string;
  readonly onConnection: (connection: Connection) => void;
  readonly onJudged: (pending: Pending, judged: Judged) => void;
  /** Called if the server refuses an answer: it isn't sent again. */
  readonly onRefused: (pending: Pending, sentence: string) => void;
}

/** Waits in milliseconds: after the last key before a draft is sent, and before further tries. */
const DRAFT_WAIT = 1000;
const TRY_WAITS = [1000, 3000, 10_000, 30_000];

/** Return the error of a request that the server will never take. Throws any other, which may pass. */
function returnRefusal(error: unknown): Refused {
  if (error instanceof Refused && !error.isTemporary) return error;
  throw error;
}

export class Outbox {
  private stored: Stored;
  private failures = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private isSending = false;
  private isEnded = false;

  constructor(private readonly options: OutboxOptions) {
    this.stored = this.load();
  }

  /** What other tabs and this one stored. */
  private load(): Stored {
    const { storage, key } = this.options;
    if (!storage) return this.stored ?? { drafts: {}, pending: [] };
    return loadJson(storage, key, parseStored);
  }

  private change(changes: (stored: Stored) => Partial<Stored>): void {
    const latest = this.load();
    this.stored = { ...latest, ...changes(latest) };
    storeText(this.options.storage, this.options.key, JSON.stringify(this.stored));
  }

  /** Return what was typed in this browser and has not reached the server; undefined if everything has. */
  draftOf = (part: string): string | undefined => this.stored.drafts[part];

  /** Return the answer to a part that is on its way, if any. */
  pendingOf = (part: string): Pending | undefined => this.stored.pending.find((pending) => pending.part === part);

  saveDraft(part: string, text: string): void {
    this.change(({ drafts }) => ({ drafts: { ...drafts, [part]: text } }));
    this.options.onConnection("saving");
    if (this.failures === 0) this.schedule(DRAFT_WAIT);
  }

  /** Submit an answer. A second press, here or in another tab, while the same answer is on its way changes nothing. */
  submit(part: string, text: string): void {
    const known = this.load().pending.find((pending) => pending.part === part);
    if (known?.text !== text) {
      const pending = { request: makeRequestId(), part, text };
      this.change((stored) => ({ pending: [...stored.pending.filter((other) => other.part !== part), pending] }));
    }
    void this.send();
  }

  /** Send everything that waits. */
  async send(): Promise<void> {
    clearTimeout(this.timer);
    if (this.isSending || this.isEnded) return;
    this.isSending = true;
    try {
      for (let next = this.load().pending[0]; next; next = this.load().pending[0]) await this.sendPending(next);
      for (const [part, text] of Object.entries(this.load().drafts)) await this.sendDraft(part, text);
      this.failures = 0;
      if (Object.keys(this.load().drafts).length > 0) this.schedule(DRAFT_WAIT);
      else this.options.onConnection("saved");
    } catch (error) {
      const { isSignedOut, status } = error instanceof Refused ? error : { isSignedOut: false, status: 0 };
      this.options.onConnection(isSignedOut ? "signed-out" : status === 429 ? "busy" : "waiting");
      this.schedule(TRY_WAITS[Math.min(this.failures, TRY_WAITS.length - 1)]!);
      this.failures += 1;
    } finally {
      this.isSending = false;
    }
  }

  private async sendPending(pending: Pending): Promise<void> {
    const judged = await request<Judged>("POST", "answers", pending).catch(returnRefusal);
    this.change((stored) => ({ pending: stored.pending.filter((other) => other.request !== pending.request) }));
    if (judged instanceof Refused) this.options.onRefused(pending, judged.message);
    else this.options.onJudged(pending, judged);
  }

  private async sendDraft(part: string, text: string): Promise<void> {
    await request("PUT", "drafts", { part, text }).catch(returnRefusal);
    this.change(({ drafts }) => {
      const { [part]: latest, ...others } = drafts;
      return { drafts: latest === undefined || latest === text ? others : drafts };
    });
  }

  private schedule(milliseconds: number): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.send(), milliseconds);
  }

  /** Send drafts while the page is left; what doesn't arrive stays in the browser. */
  leave(): void {
    for (const [part, text] of Object.entries(this.load().drafts))
      void request("PUT", "drafts", { part, text }, true).catch(() => undefined);
  }

  end(): void {
    this.isEnded = true;
    clearTimeout(this.timer);
  }
}
