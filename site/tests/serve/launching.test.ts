// @vitest-environment happy-dom
// The page of a launch and the platform's storage: only the platform's answer to our own message counts.
import { afterEach, beforeEach, expect, test, vi } from "vitest";

import { launch } from "../../src/serve/launching.js";

const ORIGIN = "https://school.example";
const sent = vi.fn();
let form: HTMLFormElement;
const submit = vi.fn();
beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("parent", { storage: { postMessage: sent } });
  document.body.innerHTML = `<form data-key="state-1" data-platform="${ORIGIN}:443/auth?a=1" data-frame="storage"><input name="proof"></form>`;
  form = document.querySelector("form")!;
  form.submit = submit;
});
afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
  vi.clearAllMocks();
  document.body.textContent = "";
});

const proof = () => form.querySelector("input")!.value;
const answer = (content: object, origin = ORIGIN) =>
  window.dispatchEvent(
    new MessageEvent("message", {
      origin,
      data: {
        ...{ subject: "lti.get_data.response", message_id: sent.mock.calls[0]![0].message_id },
        ...{ key: "state-1", value: "secret", ...content },
      },
    }),
  );

test("the value in the platform's storage is posted with the message", async () => {
  const end = launch(form);
  expect(sent.mock.calls).toEqual([[expect.objectContaining({ subject: "lti.get_data", key: "state-1" }), ORIGIN]]);
  answer({ value: "foreign" }, "https://evil.example");
  answer({ value: "foreign", message_id: "another" });
  answer({});
  await end;
  expect(proof()).toBe("secret");
  expect(submit).toHaveBeenCalledOnce();
});

test.each([{ error: { code: "bad_request" } }, { subject: "lti.put_data.response" }, null])(
  "nothing is posted after the answer %j",
  async (content) => {
    const end = expect(launch(form)).rejects.toBeUndefined();
    if (content) answer(content);
    else await vi.advanceTimersByTimeAsync(3000);
    await end;
    expect([proof(), submit.mock.calls.length]).toEqual(["", 0]);
  },
);

test("a platform without a storage is not asked", async () => {
  form.dataset["frame"] = "";
  await expect(launch(form)).rejects.toBeInstanceOf(TypeError);
});
