// A small server in place of `fetch`: it records requests, and answers them as a test says.
import { vi } from "vitest";

export type Sent = { readonly method: string; readonly path: string; readonly body: Record<string, unknown> };
/** The status and the JSON of an answer; null if the connection fails. */
export type Answer = readonly [status: number, content: unknown] | null;

/** Replace `fetch` until the test ends; return the requests so far, in their order. */
export function serve(answer: (sent: Sent) => Answer): Sent[] {
  const requests: Sent[] = [];
  vi.stubGlobal("fetch", async (path: string, { method = "GET", body }: RequestInit = {}) => {
    const sent = { method, path, body: typeof body === "string" ? JSON.parse(body) : {} } as Sent;
    requests.push(sent);
    const result = answer(sent);
    if (result === null) throw new TypeError("no connection");
    return new Response(result[0] === 204 ? null : JSON.stringify(result[1]), { status: result[0] });
  });
  return requests;
}

/** The browser's storage, shared by all tabs. */
export function makeStorage(): Storage {
  const entries = new Map<string, string>();
  return {
    getItem: (key: string) => entries.get(key) ?? null,
    setItem: (key: string, text: string) => void entries.set(key, text),
  } as unknown as Storage;
}
