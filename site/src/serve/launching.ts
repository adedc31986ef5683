// A launch from a platform: at login this page tries cookies, else the platform's storage; then it reads what is there.
// The messages are those of "LTI OIDC Login with LTI Client Side postMessages" by 1EdTech.

import { listen } from "../scheduling.js";
import { makeRequestId } from "./api.js";

/** How long the platform has for an answer, in milliseconds. */
const WAIT = 3000;

/** Put a value into the platform's storage, or read one. Rejects if the platform refuses, or doesn't answer in time. */
const askPlatform = (subject: string, { key, value, frame, platform }: DOMStringMap): Promise<string> =>
  new Promise((done, fail) => {
    const { origin } = new URL(platform!);
    const message = { subject, message_id: makeRequestId(), key, ...(value ? { value } : {}) };
    listen(window, "message", ({ data, origin: sender }: MessageEvent) => {
      if (sender !== origin || data?.message_id !== message.message_id) return;
      data.subject === `${subject}.response` && !data.error ? done(String(data.value)) : fail();
    });
    setTimeout(fail, WAIT);
    const frames = window.parent as unknown as Record<string, Window>;
    (frame === "_parent" ? window.parent : frames[frame!]!).postMessage(message, origin);
  });

/** Return whether the browser stores cookies here, if only for frames of this platform. */
function storesCookies(): boolean {
  const attributes = window.location.protocol === "https:" ? "Secure; SameSite=None; Partitioned" : "SameSite=Lax";
  document.cookie = `qdot-test=1; Max-Age=5; ${attributes}`;
  return document.cookie.includes("qdot-test=1");
}

/** Go on with a launch. Rejects if neither the browser nor the platform stores anything. */
export async function launch(form: HTMLFormElement): Promise<void> {
  const { dataset: data } = form;
  if (data["url"]) {
    if (!storesCookies()) await askPlatform("lti.put_data", data);
    window.location.replace(data["url"]);
  } else {
    form.querySelector<HTMLInputElement>("[name=proof]")!.value = await askPlatform("lti.get_data", data);
    form.submit();
  }
}
